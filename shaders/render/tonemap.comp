#version 460
#extension GL_GOOGLE_include_directive : require
// Exposed, tone mapped, sRGB encoded, dithered so that skies do not band.
#include "common/tonemap.h"
#include "render/render_shared.h"
layout(constant_id = 0) const uint kCurve = 0u;  // kTone...: one pipeline for each curve keeps the others out of the code
layout(local_size_x = 32, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, scalar) uniform StateBlock { ExposureState state; } exposure;
layout(set = 0, binding = 2, rgba8) uniform writeonly image2D display;
layout(push_constant, scalar) uniform PushBlock { TonemapPush push; };

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, push.size))) return;
  vec3 balanced = push.white_balance * texelFetch(radiance, ivec2(pixel), 0).rgb;
  vec3 v = display_from_exposed(balanced * exposure.state.exposure, kCurve);
  vec3 q = vec3(quantise(v.r, dither_pattern(pixel, push.dither_offset + 0x55555555u)),
                quantise(v.g, dither_pattern(pixel, push.dither_offset)),
                quantise(v.b, dither_pattern(pixel, push.dither_offset + 0xaaaaaaaau)));
  imageStore(display, ivec2(pixel), vec4(q * (1.0 / 255.0), 1.0));
}
