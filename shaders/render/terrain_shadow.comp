#version 460
#extension GL_GOOGLE_include_directive : require
// Share of the key light that reaches the surface of every pixel past terrain, times that through clouds.
#include "common/frame.h"
layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define TERRAIN_SHADOW_BINDING 1
#include "terrain/terrain_shadow.glsl"
layout(set = 0, binding = 3) uniform sampler2D depth_m;
layout(set = 0, binding = 4) uniform sampler2D cloud_share;  // CLOUDS
layout(set = 0, binding = 5, r32f) uniform writeonly image2D sun_visibility;
#define PIXEL_TILES_BINDING 6
#include "common/pixel_tiles.glsl"
layout(constant_id = 0) const bool CLOUDS = false;

void main() {
  ivec2 pixel = ivec2(tile_pixel());
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  float distance = texelFetch(depth_m, pixel, 0).r;
  bool surface = distance < 0.5 * kFarDepth_m;
  float share = terrain_sun_share(pixel_direction(frame.frame_data, vec2(pixel) + 0.5) * (surface ? distance : 0.0));
  if (CLOUDS) share *= texelFetch(cloud_share, pixel, 0).r;
  imageStore(sun_visibility, pixel, vec4(surface ? share : 1.0));
}
