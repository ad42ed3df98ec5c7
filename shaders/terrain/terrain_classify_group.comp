#version 460
#extension GL_GOOGLE_include_directive : require
// terrain_classify.comp for GPUs: a group per tile, whose threads read four pixels each.
#include "common/pixel_tiles.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depth_tex;
layout(scalar, set = 0, binding = 1) buffer SurfaceTileBlock { uvec4 groups; uint at[]; } surface_tiles;
layout(scalar, set = 0, binding = 2) buffer SkyTileBlock { uvec4 groups; uint at[]; } sky_tiles;
shared uint ground;

void main() {
  uvec2 tile = gl_WorkGroupID.xy;
  ivec2 last = textureSize(depth_tex, 0) - 1;
  ivec2 first = kPixelTile * ivec2(tile) + ivec2(gl_LocalInvocationID.xy);
  if (gl_LocalInvocationIndex == 0u) ground = 0u;
  barrier();
  float nearest = 0.0;  // reversed Z: 0 is the sky
  for (int i = 0; i < 4; ++i)
    nearest = max(nearest, texelFetch(depth_tex, min(first + ivec2(8 * (i & 1), 8 * (i >> 1)), last), 0).r);
  if (nearest > 0.0) atomicOr(ground, 1u);
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  uint packed = tile.x | (tile.y << 16);
  if (ground != 0u)
    surface_tiles.at[atomicAdd(surface_tiles.groups.x, 1u)] = packed;
  else
    sky_tiles.at[atomicAdd(sky_tiles.groups.x, 1u)] = packed;
}
