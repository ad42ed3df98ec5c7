#version 460
#extension GL_GOOGLE_include_directive : require
// Answers questions to the atmosphere's own lookup functions: tests, and `nepho probe`.
#include "atmosphere/atmosphere_probe_shared.h"
#define ATMOSPHERE_BINDING 2
#define ATMOSPHERE_MANY_VIEWS
#include "atmosphere/atmosphere_lookup.glsl"
layout(local_size_x = 32) in;
layout(scalar, set = 0, binding = 0) readonly buffer CaseBlock { AtmosphereCase data[]; } cases;
layout(scalar, set = 0, binding = 1) writeonly buffer AnswerBlock { AtmosphereAnswer data[]; } answers;
layout(push_constant) uniform Push { uint kind; uint count; } push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  AtmosphereCase c = cases.data[i];
  AtmosphereUniform air = atmosphere.air;
  AtmosphereAnswer answer = AtmosphereAnswer(vec3(0), vec3(0));
  AirRay ray = air_ray_from(c.planet, c.camera_up, c.sun_dir, c.dir);
  vec3 columns = vec3(0);
  if (push.kind == kProbeSkyRadiance) {
    answer.a = sky_light(ray, c.dir, sky_views.data[c.view], c.hits_ground != 0u, answer.b);
  } else if (push.kind == kProbeRadianceToPoint) {
    answer.a = light_to_point(ray, c.distance_m, c.shadow_m, columns);
    answer.b = transmittance_of(columns);
  } else if (push.kind == kProbeSingleScattering) {
    float length_m = c.hits_ground != 0u ? distance_to_ground(air, c.h, c.mu) : distance_to_top(air, c.h, c.mu);
    ScatteredLight light = scatter_along(c.h, c.mu, c.mu_s, c.nu, length_m, length_m, 1.0, 0.0);
    answer.a = light.smooth_part;
    answer.b = light.mie;
  } else if (push.kind == kProbeIrradiance) {
    answer.a = atmosphere.spectrum[0].solar_irradiance * mean_sun_cosine(air, c.mu_s) *
               transmittance_of(sampled_columns_to_top(air, c.h, c.mu_s));
    answer.b = irradiance_part(c.h, c.mu_s, 0);
  } else if (push.kind == kProbeTransmittance) {
    answer.a = transmittance_of(sampled_columns_to_top(air, c.h, c.mu));
  } else if (push.kind == kProbeLuminance) {
    vec3 transmittance;
    answer.a = sky_light(ray, c.dir, sky_views.data[c.view], c.hits_ground != 0u, transmittance) * air.luminance_factor;
    answer.b = light_to_point(ray, c.distance_m, 0.0, columns) * air.luminance_factor;
  } else if (push.kind == kProbeSunSky) {
    answer.a = atmosphere.spectrum[0].solar_irradiance * sun_transmittance(c.h, c.mu_s) * max(dot(c.dir, c.sun_dir), 0.0);
    answer.b = irradiance_part(c.h, c.mu_s, 0) * (0.5 + 0.5 * dot(c.dir, c.camera_up));
  } else {
    answer.a = sun_transmittance(c.h, c.mu_s);
    answer.b = 0.5 * (irradiance_part(c.h, c.mu_s, 1) + irradiance_part(c.h, c.mu_s, 2)) * air.luminance_factor;
  }
  answers.data[i] = answer;
}
