#version 460
#extension GL_GOOGLE_include_directive : require
// The discs of sun and moon, over the part of the picture that they may cover. The moon hides the sun, and both hide stars.
#include "common/frame.h"
#include "common/gamut.h"
#include "render/render_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;
layout(set = 0, binding = 6, rgba32f) uniform image2D background;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
#define NIGHT_SKY_BINDING 16
#include "render/night_sky.glsl"
layout(constant_id = 1) const bool kNight = true;
layout(push_constant, scalar) uniform PushBlock { DiscsPush push; };

void main() {
  ivec2 pixel = push.first + ivec2(gl_GlobalInvocationID.xy);
  FrameConstants f = frame.frame_data;
  if (any(greaterThanEqual(pixel, push.last)) || any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  if (texelFetch(depth_m, pixel, 0).r < 0.5 * kFarDepth_m) return;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  vec3 through = transmittance_to_space(f, dir);
  float hidden = moon_cover(f, dir);
  vec3 discs = moon_disc_luminance(f, dir) + sun_disc_luminance(f, dir, vec3(1.0)) * (1.0 - hidden);
  if (kNight) discs -= stars_luminance(f, pixel) * hidden;
  imageStore(background, pixel, vec4(within_rec709(imageLoad(background, pixel).rgb + discs * through), 1.0));
}
