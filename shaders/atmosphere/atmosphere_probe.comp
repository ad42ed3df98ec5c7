#version 460
#extension GL_GOOGLE_include_directive : require
// Answers questions to the atmosphere's own lookup functions: tests, and `nepho probe`.
#include "atmosphere/atmosphere_probe_shared.h"
#define ATMOSPHERE_BINDING 2
#include "atmosphere/atmosphere_lookup.glsl"
layout(local_size_x = 32) in;
layout(scalar, set = 0, binding = 0) readonly buffer CaseBlock { AtmosphereCase data[]; } cases;
layout(scalar, set = 0, binding = 1) writeonly buffer AnswerBlock { AtmosphereAnswer data[]; } answers;
layout(push_constant) uniform Push { uint kind; uint count; } push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  AtmosphereCase c = cases.data[i];
  AtmosphereUniform air = atmosphere.atmosphere_data;
  AtmosphereAnswer answer = AtmosphereAnswer(vec3(0), vec3(0));
  if (push.kind == kProbeSkyRadiance || push.kind == kProbeRadianceToPoint) {
    AirRay ray = air_ray_from(c.planet, c.camera_up, c.sun_dir, c.dir);
    if (push.kind == kProbeSkyRadiance) {
      answer.a = sky_radiance(ray, c.hits_ground != 0u, answer.b);
    } else {
      answer.a = radiance_to_point(ray, c.distance_m, answer.b);
    }
  } else if (push.kind == kProbeSingleScattering) {
    AirRay ray = AirRay(true, false, 0.0, 1.0, c.h, c.mu, c.mu_s, c.nu);
    if (c.hits_ground != 0u) {
      ScatteredLight light = scatter_along(air, c.h, c.mu, c.mu_s, c.nu, distance_to_ground(air, c.h, c.mu), true, false);
      answer.a = light.rayleigh;
      answer.b = light.mie;
    } else {
      float v = texel_coord(unit_from_sky_mu(air, c.h, c.mu), kSkyMu);
      float w = texel_coord(unit_from_height(air, c.h), kAirR);
      answer.a = sample_4d(rayleigh_tex, unit_from_nu(c.nu), unit_from_mu_s(air, c.mu_s), v, w) / kTableScale;
      answer.b = sample_4d(mie_tex, unit_from_nu(c.nu), unit_from_mu_s(air, c.mu_s), v, w) / kTableScale;
    }
  } else if (push.kind == kProbeIrradiance) {
    answer.a = air.solar_irradiance * mean_sun_cosine(air, c.mu_s) * exp(-sampled_optical_depth_to_top(air, c.h, c.mu_s));
    answer.b = irradiance_part(c.h, c.mu_s, 0);
  } else if (push.kind == kProbeTransmittance) {
    answer.a = exp(-sampled_optical_depth_to_top(air, c.h, c.mu));
  } else {
    FrameConstants frame;
    frame.planet = c.planet;
    frame.camera_up = c.camera_up;
    frame.sun_dir = c.sun_dir;
    frame.sun_illuminance = air.sun_luminance_factor * air.solar_irradiance;
    frame.sun_distance_factor = 1.0;
    frame.sun_angular_radius_rad = air.sun_angular_radius_rad;
    frame.pixel_angle_rad = 1.0e-3;
    vec3 transmittance;
    if (push.kind == kProbeLuminance) {
      answer.a = sky_luminance(frame, c.dir, c.hits_ground != 0u, transmittance);
      answer.b = aerial_perspective(frame, c.dir, c.distance_m, transmittance);
    } else {
      answer.a = sun_transmittance(c.h, c.mu_s);
      answer.b = mean_sky_luminance(frame, c.h, c.mu_s);
    }
  }
  answers.data[i] = answer;
}
