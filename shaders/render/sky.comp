#version 460
#extension GL_GOOGLE_include_directive : require
// Tiles of nothing but sky, seen from within the air, by its sky views; stars and airglow at night.
#include "common/frame.h"
#include "common/gamut.h"
layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D background;
#define PIXEL_TILES_BINDING 7
#include "common/pixel_tiles.glsl"
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
#define NIGHT_SKY_BINDING 16
#include "render/night_sky.glsl"
layout(constant_id = 1) const bool kNight = true;  // false: by day; stars, airglow and moonlight are left out

void main() {
  ivec2 pixel = ivec2(tile_pixel());
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  vec3 dir = pixel_direction(frame.frame_data, vec2(pixel) + 0.5);
  vec3 through;
  vec3 result = sky_view_luminance(frame.frame_data, dir, kNight, through);
  if (kNight) {
    result += stars_luminance(frame.frame_data, pixel) * through;
    result += airglow_luminance(frame.frame_data, dir, false, through) + night_air_luminance(through);
  }
  imageStore(background, pixel, vec4(within_rec709(result), 1.0));
}
