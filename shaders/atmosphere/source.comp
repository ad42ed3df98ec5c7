#version 460
#extension GL_GOOGLE_include_directive : require
// Source function of the next order: incident light times phase functions, per unit of scattering coefficient.
#include "atmosphere/atmosphere_shared.h"
#include "common/phase.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(scalar, set = 0, binding = 1) readonly buffer IncidentBlock { vec4 data[]; } incident;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image3D out_order;  // this order alone
layout(set = 0, binding = 3, rgba32f) uniform image3D sum;                  // of orders 2 and up
layout(push_constant) uniform Push { int order; int first_slice; } push;

void main() {
  int i_nu = int(gl_GlobalInvocationID.x) % kAirNu;
  int i_mu = int(gl_GlobalInvocationID.x) / kAirNu;
  int i_mu_s = int(gl_GlobalInvocationID.y);
  int i_h = int(gl_GlobalInvocationID.z) + push.first_slice;
  if (i_mu >= kSourceMu || i_h >= kAirR) return;
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float h = height_from_unit(air, unit_from_texel(i_h, kAirR));
  float mu_s = mu_s_from_unit(air, unit_from_texel(i_mu_s, kAirMuS));
  float mu = -1.0 + 2.0 * unit_from_texel(i_mu, kSourceMu);
  float nu = possible_nu(mu, mu_s, nu_from_unit(unit_from_texel(i_nu, kAirNu)));
  // Direction of the texel in the frame of local_direction(): its azimuth follows from nu.
  float sin_sin = sqrt(max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0));
  float cos_phi = sin_sin > 1.0e-6 ? clamp((nu - mu * mu_s) / sin_sin, -1.0, 1.0) : 1.0;
  float sin_mu = sqrt(max(1.0 - mu * mu, 0.0));
  vec2 across = sin_mu * vec2(cos_phi, sqrt(1.0 - cos_phi * cos_phi));

  int base = (i_h * kAirMuS + i_mu_s) * kIncidentDirections;
  vec3 rayleigh = vec3(0);
  vec3 mie = vec3(0);
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
      vec3 light = incident.data[base + i * kIncidentPhi + j].rgb;
      // The light is the same at azimuths phi and -phi.
      float pr = weight * (phase_rayleigh(along + beside) + phase_rayleigh(along - beside));
      float pm = weight * (phase_cornette_shanks(along + beside, air.mie_g) + phase_cornette_shanks(along - beside, air.mie_g));
      rayleigh += pr * light;
      mie += pm * light;
      mie_norm += pm;
    }
  }
  vec3 k_rayleigh = air.rayleigh_scattering_per_m * rayleigh_density(air, h);
  vec3 k_mie = air.mie_scattering_per_m * mie_density(air, h);
  vec3 source = (k_rayleigh * rayleigh + k_mie * mie / max(mie_norm, 1.0e-6)) / max(k_rayleigh + k_mie, vec3(1.0e-30));
  ivec3 at = ivec3(i_nu * kAirMuS + i_mu_s, i_mu, i_h);
  imageStore(out_order, at, vec4(source, 0));
  imageStore(sum, at, vec4(source, 0) + (push.order > 2 ? imageLoad(sum, at) : vec4(0)));
}
