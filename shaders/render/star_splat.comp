#version 460
#extension GL_GOOGLE_include_directive : require
// One thread per star: adds its illuminance to the pixels around its place. Whole numbers, so that the order of the stars
// does not change the sum.
#include "render/night_sky_shared.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1, scalar) readonly buffer StarBlock { StarOnGpu values[]; } stars;
layout(set = 0, binding = 2, scalar) buffer StarPixelBlock { uint values[]; } star_pixels;
layout(push_constant, scalar) uniform PushBlock { StarSplatPush push; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.star_count) return;
  FrameConstants f = frame.frame_data;
  StarOnGpu star = stars.values[i];
  vec2 place;
  if (!pixel_from_direction(f, push.ecef_from_icrs * star.dir_icrs, place)) return;
  ivec2 size = ivec2(f.size);
  vec2 cell = floor(place);
  if (any(lessThan(cell, vec2(-kStarReach_px))) || any(greaterThanEqual(cell, vec2(size + kStarReach_px)))) return;
  ivec2 centre = ivec2(cell);
  vec2 at = place - cell - 0.5;
  vec3 units = star.color * (star.illuminance_lux * push.units_per_lux);
  for (int k = 0; k < 25; ++k) {
    ivec2 offset = ivec2(k % 5, k / 5) - kStarReach_px;
    ivec2 pixel = centre + offset;
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size))) continue;
    uvec3 add = uvec3(units * (star_weight(offset.x, at.x) * star_weight(offset.y, at.y)) + 0.5);
    uint first = 3u * (uint(pixel.y) * f.size.x + uint(pixel.x));
    atomicAdd(star_pixels.values[first], add.x);
    atomicAdd(star_pixels.values[first + 1u], add.y);
    atomicAdd(star_pixels.values[first + 2u], add.z);
  }
}
