#version 460
#extension GL_GOOGLE_include_directive : require
// Sums one order's incident light: irradiance of a horizontal plane from above the horizontal, mean radiance of the
// hemispheres above and below it, and its second moments, from which gas scatters it again (source.comp). All per unit of
// sunlight.
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const int kSpectralGroups = 1;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform air; SpectralGroup spectrum[kMaxSpectralGroups]; } atmosphere;
layout(scalar, set = 0, binding = 1) readonly buffer IncidentBlock { vec3 data[]; } incident;
layout(scalar, set = 0, binding = 2) writeonly buffer OrderIrradianceBlock { vec3 data[]; } order_irradiance;  // at the ground, this order
layout(scalar, set = 0, binding = 3) writeonly buffer MomentBlock { vec3 data[]; } moments;  // xx, yy, zz, xz per group
layout(scalar, set = 0, binding = 4) buffer SumBlock { vec3 data[]; } irradiance_sum;        // three parts per group, all orders
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_irradiance;              // their coefficients
layout(push_constant) uniform Push { int order; } push;

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (texel.x >= kAirMuS || texel.y >= kAirR) return;
  AtmosphereUniform air = atmosphere.air;
  float h = height_from_unit(air, unit_from_texel(texel.y, kAirR));
  int cell = texel.y * kAirMuS + texel.x;
  vec4 coefficients[3] = {vec4(0), vec4(0), vec4(0)};
  for (int g = 0; g < kSpectralGroups; ++g) {
    vec3 part[3] = {vec3(0), vec3(0), vec3(0)};
    vec3 xx = vec3(0), yy = vec3(0), zz = vec3(0), xz = vec3(0);
    for (int i = 0; i < kIncidentMu; ++i) {
      vec2 mu = incident_mu(air, h, i);
      vec3 all = vec3(0), c1 = vec3(0), c2 = vec3(0);
      for (int j = 0; j < kIncidentPhi; ++j) {
        vec3 light = incident.data[(cell * kIncidentDirections + i * kIncidentPhi + j) * kSpectralGroups + g];
        float c = cos(incident_phi(j));
        all += light;
        c1 += c * light;
        c2 += c * c * light;
      }
      float weight = mu.y * (2.0 * kPi / float(kIncidentPhi));  // both halves of the azimuth
      float sin2 = 1.0 - mu.x * mu.x;
      xx += weight * sin2 * c2;
      yy += weight * sin2 * (all - c2);
      zz += weight * mu.x * mu.x * all;
      xz += weight * mu.x * sqrt(max(sin2, 0.0)) * c1;
      if (i >= kIncidentGround + kIncidentBand) {
        part[0] += weight * mu.x * all;
        part[1] += (weight * 0.5 / kPi) * all;
      } else {
        part[2] += (weight * 0.5 / kPi) * all;
      }
    }
    int at = (cell * kSpectralGroups + g) * 4;
    moments.data[at] = xx;
    moments.data[at + 1] = yy;
    moments.data[at + 2] = zz;
    moments.data[at + 3] = xz;
    if (texel.y == 0) order_irradiance.data[texel.x * kSpectralGroups + g] = part[0];
    for (int k = 0; k < 3; ++k) {
      int to = (cell * kSpectralGroups + g) * 3 + k;
      vec3 sum = part[k] + (push.order > 1 ? irradiance_sum.data[to] : vec3(0));
      irradiance_sum.data[to] = sum;
      coefficients[k] += atmosphere.spectrum[g].fit * log(max(sum, vec3(kLeastLight)));
    }
  }
  for (int k = 0; k < 3; ++k) imageStore(out_irradiance, texel + ivec2(0, k * kAirR), coefficients[k]);
}
