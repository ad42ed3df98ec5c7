#version 460
#extension GL_GOOGLE_include_directive : require
// Optical depth to the top of the air, at 680, 550, 440 nm.
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 16, local_size_y = 4) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D out_transmittance;

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (texel.x >= kTransmittanceMu || texel.y >= kTransmittanceR) return;
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float h = height_from_unit(air, unit_from_texel(texel.y, kTransmittanceR));
  float mu = sky_mu_from_unit(air, h, unit_from_texel(texel.x, kTransmittanceMu));
  imageStore(out_transmittance, texel, vec4(optical_depth_to_top(air, h, mu), 0));
}
