#version 460
#extension GL_GOOGLE_include_directive : require
// Columns of gas, aerosol and ozone to the top of the air: optical depth at any wavelength follows from them.
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 16, local_size_y = 4) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform air; SpectralGroup spectrum[kMaxSpectralGroups]; } atmosphere;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D out_columns;

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (texel.x >= kColumnMu || texel.y >= kColumnR) return;
  AtmosphereUniform air = atmosphere.air;
  float h = height_from_unit(air, unit_from_texel(texel.y, kColumnR));
  float mu = sky_mu_from_unit(air, h, unit_from_texel(texel.x, kColumnMu));
  imageStore(out_columns, texel, vec4(columns_to_top(air, h, mu), 0));
}
