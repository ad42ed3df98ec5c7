#version 460
#extension GL_GOOGLE_include_directive : require
// Exposed, tone mapped, sRGB encoded, dithered by half a step so that skies do not band.
#include "common/tonemap.h"
#include "render/render_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, scalar) readonly buffer StateBlock { ExposureState state; } exposure;
layout(set = 0, binding = 2, rgba8) uniform writeonly image2D display;
layout(push_constant, scalar) uniform PushBlock { TonemapPush push; };

// Jimenez 2014: interleaved gradient noise, 0..1.
float gradient_noise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, push.size))) return;
  vec3 balanced = max(push.white_balance * texelFetch(radiance, ivec2(pixel), 0).rgb, vec3(0.0));
  vec3 v = tone_map(balanced * exposure.state.exposure, push.curve);
  vec3 s = vec3(srgb_from_linear(v.r), srgb_from_linear(v.g), srgb_from_linear(v.b));
  vec2 p = vec2(pixel) + 5.588238 * float(push.seed % 64u);
  vec3 noise = vec3(gradient_noise(p), gradient_noise(p + 17.0), gradient_noise(p + 43.0)) - 0.5;
  imageStore(display, ivec2(pixel), vec4(clamp(s + noise / 255.0, 0.0, 1.0), 1.0));
}
