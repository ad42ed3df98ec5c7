#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the tiles of 8 x 8 pixels that show some ground, and those of sky only (common/pixel_tiles.glsl); the latter get their
// values here, the former in terrain_resolve.comp. A thread per tile: barriers are dear on a software device.
#include "common/shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depth_tex;
layout(scalar, set = 0, binding = 1) buffer SurfaceTileBlock { uvec4 groups; uint at[]; } surface_tiles;
layout(scalar, set = 0, binding = 2) buffer SkyTileBlock { uvec4 groups; uint at[]; } sky_tiles;
layout(set = 0, binding = 3, r32f) uniform writeonly image2D out_depth_m;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D out_albedo;

void main() {
  uvec2 tile = gl_GlobalInvocationID.xy;
  ivec2 size = textureSize(depth_tex, 0);
  ivec2 first = 8 * ivec2(tile);
  if (any(greaterThanEqual(first, size))) return;
  float nearest = 0.0;  // reversed Z: 0 is the sky
  for (int i = 0; i < 64; ++i)
    nearest = max(nearest, texelFetch(depth_tex, min(first + ivec2(i & 7, i >> 3), size - 1), 0).r);
  uint packed = tile.x | (tile.y << 16);
  if (nearest > 0.0) {
    surface_tiles.at[atomicAdd(surface_tiles.groups.x, 1u)] = packed;
    return;
  }
  sky_tiles.at[atomicAdd(sky_tiles.groups.x, 1u)] = packed;
  for (int i = 0; i < 64; ++i) {
    ivec2 at = first + ivec2(i & 7, i >> 3);  // stores outside the picture do nothing
    imageStore(out_depth_m, at, vec4(kFarDepth_m));
    imageStore(out_albedo, at, vec4(0.0));
  }
}
