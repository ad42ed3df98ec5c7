#version 460
#extension GL_GOOGLE_include_directive : require
// Tables of the light that arrives at points near the camera (air_volume_shared.h): logarithms, by height and the light's cosine.
#include "common/frame.h"
#include "atmosphere/air_volume_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform VolumeBlock { AirVolumeData data; } air_volume;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D out_tables;
#define ATMOSPHERE_BINDING 3
#include "atmosphere/atmosphere_lookup.glsl"

vec3 logarithm(vec3 light) { return log(max(light, vec3(kLeastTabled))); }

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  AirVolumeData volume = air_volume.data;
  FrameConstants f = frame.frame_data;
  AtmosphereUniform air = atmosphere.air;
  float h = light_row_height(volume, unit_from_texel(at.y, kLightHeights));
  vec3 mu = volume.mu_low + unit_from_texel(at.x, kLightMu) * volume.mu_span;
  ivec2 down = ivec2(0, kLightHeights);
  // The part of the disc above the horizon is the reader's: it changes faster than the table's columns.
  imageStore(out_tables, at, vec4(logarithm(transmittance_of(sampled_columns_to_top(air, h, mu.x))), 1.0));
  imageStore(out_tables, at + down, vec4(logarithm(irradiance_part(h, mu.y, 0) * light_factor(f, 0)), 1.0));
  vec3 rest = f.moon_share * f.sun_illuminance_1au - step(0.99999, dot(f.key_dir, f.moon_dir)) * f.key_illuminance;
  imageStore(out_tables, at + 2 * down, vec4(logarithm(irradiance_part(h, mu.z, 0) * light_factor(f, 1)), 1.0));
  imageStore(out_tables, at + 3 * down, vec4(logarithm(max(rest, vec3(0.0)) * transmittance_of(sampled_columns_to_top(air, h, mu.z))), 1.0));
}
