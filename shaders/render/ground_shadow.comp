#version 460
#extension GL_GOOGLE_include_directive : require
// Share of the sun's light that clouds let through to the surface of every pixel.
#include "common/frame.h"
layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_shadow_march.glsl"
layout(set = 0, binding = 20) uniform sampler2D depth_m;
layout(set = 0, binding = 21, r32f) uniform writeonly image2D sun_visibility;
#define PIXEL_TILES_BINDING 22
#include "common/pixel_tiles.glsl"
void main() {
  ivec2 pixel = ivec2(tile_pixel());
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  float distance = texelFetch(depth_m, pixel, 0).r;
  float visible = 1.0;
  if (distance < 0.5 * kFarDepth_m) {
    vec3 dir = pixel_direction(frame.frame_data, vec2(pixel) + 0.5);
    visible = cloud_sun_transmittance(dir * distance);
  }
  imageStore(sun_visibility, pixel, vec4(visible));
}
