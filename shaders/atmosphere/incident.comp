#version 460
#extension GL_GOOGLE_include_directive : require
// Light of one scattering order that arrives at a height from kIncidentDirections directions, ground included. It depends
// on height, sun and direction only, so that the next order's source function is a plain sum over it (source.comp).
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(set = 0, binding = 1) uniform sampler2D transmittance_tex;
layout(set = 0, binding = 2) uniform sampler2D irradiance_tex;  // of the order before, from the sky
layout(set = 0, binding = 3) uniform sampler3D source_tex;      // of this order
layout(scalar, set = 0, binding = 4) writeonly buffer IncidentBlock { vec4 data[]; } incident;
layout(push_constant) uniform Push { int order; } push;

#define AIR_PATH_NODES 12
#define SOURCE_TEX source_tex
#define SOURCE_ROW0 0.0
#define SOURCE_ROWS float(kSourceMu)
#define SOURCE_SCALE 1.0
#include "atmosphere/air_path.glsl"

void main() {
  int direction = int(gl_GlobalInvocationID.x);
  int i_mu_s = int(gl_GlobalInvocationID.y);
  int i_h = int(gl_GlobalInvocationID.z);
  if (direction >= kIncidentDirections) return;
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float h = height_from_unit(air, unit_from_texel(i_h, kAirR));
  float mu_s = mu_s_from_unit(air, unit_from_texel(i_mu_s, kAirMuS));
  int i_mu = direction / kIncidentPhi;
  float mu = incident_mu(air, h, i_mu).x;
  vec3 dir = local_direction(mu, incident_phi(direction % kIncidentPhi));
  float nu = dot(dir, local_direction(mu_s, 0.0));
  bool ground = i_mu < kIncidentGround;
  float length_m = ground ? distance_to_ground(air, h, mu) : distance_to_top(air, h, mu);
  bool first = push.order == 1;
  ScatteredLight air_light = scatter_along(air, h, mu, mu_s, nu, length_m, first, !first);
  vec3 light = first ? air_light.rayleigh * phase_rayleigh(nu) + air_light.mie * phase_cornette_shanks(nu, air.mie_g)
                     : air_light.multiple;
  if (ground) {
    float mu_s_ground = clamp(((air.radius_m + h) * mu_s + length_m * nu) / air.radius_m, -1.0, 1.0);
    vec3 lit;
    if (first) {
      lit = air.solar_irradiance * mean_sun_cosine(air, mu_s_ground) * exp(-sampled_optical_depth_to_top(air, 0.0, mu_s_ground));
    } else {
      lit = textureLod(irradiance_tex, vec2(texel_coord(unit_from_mu_s(air, mu_s_ground), kAirMuS), 0.5 / float(kIrradianceParts * kAirR)), 0.0).rgb;
    }
    light += exp(-air_light.optical_depth) * lit * (air.ground_albedo / kPi);
  }
  incident.data[(i_h * kAirMuS + i_mu_s) * kIncidentDirections + direction] = vec4(light, 0);
}
