#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the tiles of pixels that show some ground, and those of sky only (common/pixel_tiles.glsl). A thread per tile: barriers are dear on a software device.
#include "common/pixel_tiles.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depth_tex;
layout(scalar, set = 0, binding = 1) buffer SurfaceTileBlock { uvec4 groups; uint at[]; } surface_tiles;
layout(scalar, set = 0, binding = 2) buffer SkyTileBlock { uvec4 groups; uint at[]; } sky_tiles;

void main() {
  uvec2 tile = gl_GlobalInvocationID.xy;
  ivec2 size = textureSize(depth_tex, 0);
  ivec2 first = kPixelTile * ivec2(tile);
  if (any(greaterThanEqual(first, size))) return;
  float nearest = 0.0;  // reversed Z: 0 is the sky
  for (int i = 0; i < kPixelTile * kPixelTile; ++i)
    nearest = max(nearest, texelFetch(depth_tex, min(first + ivec2(i % kPixelTile, i / kPixelTile), size - 1), 0).r);
  uint packed = tile.x | (tile.y << 16);
  if (nearest > 0.0)
    surface_tiles.at[atomicAdd(surface_tiles.groups.x, 1u)] = packed;
  else
    sky_tiles.at[atomicAdd(sky_tiles.groups.x, 1u)] = packed;
}
