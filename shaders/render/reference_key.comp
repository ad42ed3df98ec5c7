#version 460
#extension GL_GOOGLE_include_directive : require
// The key light through clear air over (cosine of its zenith angle, height), lux per channel: paths look it up at every vertex.
#include "clouds/path_shared.h"
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D out_key;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, ivec2(kKeyWidth, kKeyHeight)))) return;
  float mu = key_mu_from_unit(float(at.x) / float(kKeyWidth - 1u));
  float height_m = mix(kKeyLow_m, kKeyHigh_m, float(at.y) / float(kKeyHeight - 1u));
  imageStore(out_key, at, vec4(key_illuminance(frame.frame_data, height_m, mu), 1.0));
}
