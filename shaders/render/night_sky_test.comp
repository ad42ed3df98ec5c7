#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: what night_sky.glsl says of every pixel, without air.
#include "common/frame.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D stars_out;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D moon_out;      // a: cover
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D airglow_out;   // through air that lets nothing pass: a, all: rgb
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D light_out;     // on the ground
#define NIGHT_SKY_BINDING 5
#include "render/night_sky.glsl"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  FrameConstants f = frame.frame_data;
  if (any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  vec2 t;
  bool hits_ground = intersect_shell(f.planet, dir, 0.0, t) && t.y > 0.0 && t.x > 0.0;
  imageStore(stars_out, pixel, vec4(stars_luminance(f, pixel), 1.0));
  imageStore(moon_out, pixel, vec4(moon_disc_luminance(f, dir), moon_cover(f, dir)));
  imageStore(airglow_out, pixel, vec4(airglow_luminance(f, dir, hits_ground, vec3(1)), airglow_luminance(f, dir, hits_ground, vec3(0)).g));
  imageStore(light_out, pixel, vec4(night_illuminance_lux(), night_bodies_luminance(f, pixel, dir).g));
}
