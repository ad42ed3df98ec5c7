// A picture in tiles of kPixelTile^2 pixels, listed by what they show, so that each kind runs a shader of its own: a branch would cost
// both sides (on a software device always, on a GPU in mixed groups). Made by terrain_classify.comp; dispatched indirectly with
// one group of as many threads per tile.
//
//   #define PIXEL_TILES_BINDING 9
//   #include "common/pixel_tiles.glsl"
#include "common/pixel_tiles.h"
layout(scalar, set = 0, binding = PIXEL_TILES_BINDING) readonly buffer PixelTileBlock {
  uvec4 groups;  // x: number of tiles
  uint at[];     // x | y << 16, in tiles
} pixel_tiles;

uvec2 tile_pixel() {
  uint tile = pixel_tiles.at[gl_WorkGroupID.x];
  return uint(kPixelTile) * uvec2(tile & 0xffffu, tile >> 16) + gl_LocalInvocationID.xy;
}
