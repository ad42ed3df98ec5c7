#version 460
#extension GL_GOOGLE_include_directive : require
// terrain_classify.comp for GPUs: a group per tile, whose threads read four pixels each, and fill them in the sky: clears of whole
// images are slow on data-centre chips.
#include "common/planet.h"
#include "common/pixel_tiles.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depth_tex;
layout(scalar, set = 0, binding = 1) buffer SurfaceTileBlock { uvec4 groups; uint at[]; } surface_tiles;
layout(scalar, set = 0, binding = 2) buffer SkyTileBlock { uvec4 groups; uint at[]; } sky_tiles;
layout(set = 0, binding = 3, r32f) uniform writeonly image2D out_depth_m;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D out_albedo;
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
  if (ground == 0u)
    for (int i = 0; i < 4; ++i) {
      ivec2 pixel = first + ivec2(8 * (i & 1), 8 * (i >> 1));
      if (any(greaterThan(pixel, last))) continue;
      imageStore(out_depth_m, pixel, vec4(kFarDepth_m));
      imageStore(out_albedo, pixel, vec4(0.0));
    }
  if (gl_LocalInvocationIndex != 0u) return;
  uint packed = tile.x | (tile.y << 16);
  if (ground != 0u)
    surface_tiles.at[atomicAdd(surface_tiles.groups.x, 1u)] = packed;
  else
    sky_tiles.at[atomicAdd(sky_tiles.groups.x, 1u)] = packed;
}
