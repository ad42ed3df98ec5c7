#version 460
#extension GL_GOOGLE_include_directive : require
// Source function of the next order: incident light times phase functions, per unit of scattering coefficient and of
// sunlight. Gas needs the second moments of the light only, 3 / (16 pi) (I + d.M d); aerosol a sum over all directions.
#include "atmosphere/atmosphere_shared.h"
#include "common/phase.h"
layout(local_size_x = 64) in;
layout(constant_id = 0) const int kSpectralGroups = 1;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform air; SpectralGroup spectrum[kMaxSpectralGroups]; } atmosphere;
layout(scalar, set = 0, binding = 1) readonly buffer IncidentBlock { vec3 data[]; } incident;
layout(scalar, set = 0, binding = 2) readonly buffer MomentBlock { vec3 data[]; } moments;
layout(scalar, set = 0, binding = 3) buffer SumBlock { vec3 data[]; } source_sum;  // of orders 2 and up
layout(set = 0, binding = 4, rgba32f) uniform writeonly image3D out_order;         // coefficients of this order alone
layout(set = 0, binding = 5, rgba32f) uniform writeonly image3D out_source;        // of all
layout(push_constant) uniform Push { int order; int first_slice; } push;

void main() {
  int i_nu = int(gl_GlobalInvocationID.x) % kAirNu;
  int i_mu = int(gl_GlobalInvocationID.x) / kAirNu;
  int i_mu_s = int(gl_GlobalInvocationID.y);
  int i_h = int(gl_GlobalInvocationID.z) + push.first_slice;
  if (i_mu >= kSourceMu || i_h >= kAirR) return;
  AtmosphereUniform air = atmosphere.air;
  float h = height_from_unit(air, unit_from_texel(i_h, kAirR));
  float mu_s = mu_s_from_unit(air, unit_from_texel(i_mu_s, kAirMuS));
  float mu = -1.0 + 2.0 * unit_from_texel(i_mu, kSourceMu);
  float nu = possible_nu(mu, mu_s, nu_from_unit(unit_from_texel(i_nu, kAirNu)));
  // Direction of the texel in the frame of local_direction(): its azimuth follows from nu.
  float sin_sin = sqrt(max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0));
  float cos_phi = sin_sin > 1.0e-6 ? clamp((nu - mu * mu_s) / sin_sin, -1.0, 1.0) : 1.0;
  float sin_mu = sqrt(max(1.0 - mu * mu, 0.0));
  vec2 across = sin_mu * vec2(cos_phi, sqrt(1.0 - cos_phi * cos_phi));

  int cell = i_h * kAirMuS + i_mu_s;
  vec3 mie[kMaxSpectralGroups];
  for (int g = 0; g < kSpectralGroups; ++g) mie[g] = vec3(0);
  float mie_norm = 0.0;  // the peak of the aerosol phase function is narrow for these nodes: keep its integral 1
  vec2 first = vec2(cos(incident_phi(0)), sin(incident_phi(0)));
  vec2 step_phi = vec2(cos(kPi / float(kIncidentPhi)), sin(kPi / float(kIncidentPhi)));
  for (int i = 0; i < kIncidentMu; ++i) {
    vec2 in_mu = incident_mu(air, h, i);
    float sin_in = sqrt(max(1.0 - in_mu.x * in_mu.x, 0.0));
    float weight = in_mu.y * (kPi / float(kIncidentPhi));
    vec2 turn = first;  // cos, sin of incident_phi(j)
    for (int j = 0; j < kIncidentPhi; ++j) {
      float along = mu * in_mu.x + sin_in * across.x * turn.x;
      float beside = sin_in * across.y * turn.y;
      turn = vec2(turn.x * step_phi.x - turn.y * step_phi.y, turn.x * step_phi.y + turn.y * step_phi.x);
      // The light is the same at azimuths phi and -phi.
      float pm = weight * (phase_aerosol(air, along + beside) + phase_aerosol(air, along - beside));
      mie_norm += pm;
      int at = (cell * kIncidentDirections + i * kIncidentPhi + j) * kSpectralGroups;
      for (int g = 0; g < kSpectralGroups; ++g) mie[g] += pm * incident.data[at + g];
    }
  }
  vec3 d = vec3(across, mu);
  float inv_norm = 1.0 / max(mie_norm, 1.0e-6);
  int texel = ((i_h * kSourceMu + i_mu) * kAirMuS + i_mu_s) * kAirNu + i_nu;
  vec4 order_fit = vec4(0), sum_fit = vec4(0);
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    int at = (cell * kSpectralGroups + g) * 4;
    vec3 xx = moments.data[at], yy = moments.data[at + 1], zz = moments.data[at + 2], xz = moments.data[at + 3];
    vec3 rayleigh = (3.0 / (16.0 * kPi)) *
                    (xx * (1.0 + d.x * d.x) + yy * (1.0 + d.y * d.y) + zz * (1.0 + d.z * d.z) + xz * (2.0 * d.x * d.z));
    vec3 k_rayleigh = group.rayleigh_scattering_per_m * rayleigh_density(air, h);
    vec3 k_mie = group.mie_scattering_per_m * mie_density(air, h);
    vec3 source = (k_rayleigh * rayleigh + k_mie * mie[g] * inv_norm) / max(k_rayleigh + k_mie, vec3(1.0e-30));
    vec3 sum = source + (push.order > 2 ? source_sum.data[texel * kSpectralGroups + g] : vec3(0));
    source_sum.data[texel * kSpectralGroups + g] = sum;
    order_fit += group.fit * log(max(source, vec3(kLeastLight)));
    sum_fit += group.fit * log(max(sum, vec3(kLeastLight)));
  }
  ivec3 to = ivec3(i_nu * kAirMuS + i_mu_s, i_mu, i_h);
  imageStore(out_order, to, order_fit);
  imageStore(out_source, to, sum_fit);
}
