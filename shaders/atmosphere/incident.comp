#version 460
#extension GL_GOOGLE_include_directive : require
// Light of one scattering order that arrives at a height from kIncidentDirections directions, ground included, per unit of
// sunlight. It depends on height, sun and direction only, so that the next order's source function is a plain sum over it
// (source.comp).
#define ATMOSPHERE_BINDING 0  // source_tex holds this order alone
#define AIR_PATH_NODES 12
#include "atmosphere/atmosphere_light.glsl"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 3) readonly buffer OrderIrradianceBlock { vec3 data[]; } order_irradiance;  // of the order before
layout(scalar, set = 0, binding = 4) writeonly buffer IncidentBlock { vec3 data[]; } incident;
layout(constant_id = 1) const bool kFirstOrder = true;
layout(push_constant) uniform Push { int order; int first_slice; } push;

void main() {
  int direction = int(gl_GlobalInvocationID.x);
  int i_mu_s = int(gl_GlobalInvocationID.y);
  int i_h = int(gl_GlobalInvocationID.z) + push.first_slice;
  if (direction >= kIncidentDirections || i_h >= kAirR) return;
  AtmosphereUniform air = atmosphere.air;
  float h = height_from_unit(air, unit_from_texel(i_h, kAirR));
  float mu_s = mu_s_from_unit(air, unit_from_texel(i_mu_s, kAirMuS));
  int i_mu = direction / kIncidentPhi;
  float mu = incident_mu(air, h, i_mu).x;
  vec3 dir = local_direction(mu, incident_phi(direction % kIncidentPhi));
  float nu = dot(dir, local_direction(mu_s, 0.0));
  bool ground = i_mu < kIncidentGround;
  float length_m = ground ? distance_to_ground(air, h, mu) : distance_to_top(air, h, mu);
  AirPath path = air_path(air, h, mu, mu_s, nu, length_m, length_m);
  float phase_r = phase_rayleigh(nu), phase_m = phase_aerosol(air, nu);

  vec3 light[kMaxSpectralGroups];
  for (int g = 0; g < kSpectralGroups; ++g) light[g] = vec3(0);
  vec3 columns = vec3(0);
  int count = node_count(path);
  for (int i = 0; i < count; ++i) {
    AirNode node = air_node(air, path, i);
    columns += node.weight_m * node.density;
    vec4 source = kFirstOrder ? vec4(0) : sampled_source(air, source_tex, node, nu);
    for (int g = 0; g < kSpectralGroups; ++g) {
      SpectralGroup group = atmosphere.spectrum[g];
      vec3 gas = node.density.x * group.rayleigh_scattering_per_m;
      vec3 aerosol = node.density.y * group.mie_scattering_per_m;
      if (kFirstOrder)
        light[g] += (node.weight_m * node.sunlit) * exp(-optical_depth(group, node.columns + node.columns_to_sun)) *
                    (gas * phase_r + aerosol * phase_m);
      else
        light[g] += (node.weight_m * night_fade(air, node.mu_s)) * (gas + aerosol) * exp(group.basis * source - optical_depth(group, node.columns));
    }
  }
  columns = path_columns(air, path, columns);

  float mu_s_ground = clamp(((air.radius_m + h) * mu_s + length_m * nu) / air.radius_m, -1.0, 1.0);
  vec3 columns_to_sun = sampled_columns_to_top(air, 0.0, max(mu_s_ground, 0.0));
  float x = unit_from_mu_s(air, mu_s_ground) * float(kAirMuS - 1);
  int i0 = min(int(x), kAirMuS - 2);
  int base = ((i_h * kAirMuS + i_mu_s) * kIncidentDirections + direction) * kSpectralGroups;
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    if (ground) {
      vec3 lit;
      if (kFirstOrder)
        lit = mean_sun_cosine(air, mu_s_ground) * exp(-optical_depth(group, columns_to_sun));
      else
        lit = mix(order_irradiance.data[i0 * kSpectralGroups + g], order_irradiance.data[(i0 + 1) * kSpectralGroups + g], x - float(i0));
      light[g] += exp(-optical_depth(group, columns)) * lit * (air.ground_albedo / kPi);
    }
    incident.data[base + g] = light[g];
  }
}
