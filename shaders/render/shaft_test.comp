#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: single scattering by air along rays, and the share of the sun that a fine march through the clouds' density lets through to
// every step. One invocation a step.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
#include "clouds/shadow_map.glsl"
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
const int kEyeLooks = 8;  // at the density, in a step
struct Stretch { vec3 dir; float from_m, to_m; };
// Luminance of the step, unshaded; share of the sun, and by the shadow maps; extinction of clouds, 1/m.
struct Step { vec3 single; float visible, by_map, cloud_per_m; };
layout(scalar, set = 0, binding = 19) readonly buffer StretchBlock { Stretch at[]; } stretches;
layout(scalar, set = 0, binding = 20) writeonly buffer StepBlock { Step at[]; } steps;
layout(push_constant, scalar) uniform PushBlock { uint first, count, steps_of_a_ray; float step_m, low_m, high_m; } push;

float extinction(vec3 p, vec3 up, float height_m, out float reach) {
  float sum = 0.0;
  reach = -9.0;
  CloudWeather w = cloud_weather_at(p, up, 0.0);
  for (uint k = 0u; k < CLOUD.caster_count; ++k) {
    uint l = CLOUD.casters[k];
    CloudColumn c = cloud_column(l, w, p, up, height_m, 0.0);
    float eta = cloud_eta(l, c, height_m), unknown = c.unknown;
    float field = cloud_full_field(l, c, p, up, height_m, clamp(eta, 0.0, 1.0), 0.0, unknown);
    float level = field - cell_threshold(cloud_need(l, c, clamp(eta, 0.0, 1.0)), c.probit);
    if (eta > 0.0 && eta < 1.0) {
      sum += cloud_medium(l, c.density, level, unknown, 0.0, eta, 1.0).mean_per_m;
      reach = max(reach, eta < 0.05 ? 0.0 : level);
    }
  }
  return sum;
}

void main() {
  uint id = push.first + gl_GlobalInvocationID.x;
  if (gl_GlobalInvocationID.x >= push.count) return;
  uint ray_id = id / push.steps_of_a_ray, i = id - ray_id * push.steps_of_a_ray;
  Stretch stretch = stretches.at[ray_id];
  FrameConstants f = frame.frame_data;
  float step_m = (stretch.to_m - stretch.from_m) / float(push.steps_of_a_ray), t = stretch.from_m + (float(i) + 0.5) * step_m;
  // Air: every column anew from the tables.
  AirRay ray = air_ray_from(f.planet, f.camera_up, f.key_dir, stretch.dir);
  AtmosphereUniform air = atmosphere.air;
  vec3 columns_to_eye;
  float length_m = (t - ray.start_m) * ray.stretch;
  AirPath path = air_path(air, ray.h, ray.mu, ray.mu_s, ray.nu, length_m, length_m);
  vec3 columns = path_columns(air, path, vec3(0.0));
  if (length_m < 30000.0) {
    columns = vec3(0.0);
    for (int k = 0; k < node_count(path); ++k) {
      AirNode node = air_node(air, path, k);
      columns += node.weight_m * node.density;
    }
  }
  float h = height_along(air, ray.h, ray.mu, length_m), r = air.radius_m + ray.h;
  float mu_s = clamp((r * ray.mu_s + length_m * ray.nu) / (air.radius_m + h), -1.0, 1.0);
  columns += sampled_columns_to_top(air, h, mu_s);
  vec3 density = densities(air, h), single = vec3(0.0);
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    single += group.rgb * ((phase_rayleigh(ray.nu) * density.x * group.rayleigh_scattering_per_m + phase_aerosol(air, ray.nu) * density.y * group.mie_scattering_per_m) *
                           (sun_visibility(air, h, mu_s) * group.solar_irradiance * exp(-optical_depth(group, columns))));
  }
  // Clouds.
  Flight flight = flight_from(stretch.dir * t, f.key_dir);
  Place here = place_on(flight);
  float reach, tau = 0.0;
  float cloud_per_m = 0.0;
  for (int k = 0; k < kEyeLooks; ++k) {
    vec3 p = stretch.dir * (t + ((float(k) + 0.5) / float(kEyeLooks) - 0.5) * step_m);
    Place eye = place_on(flight_from(p, f.key_dir));
    if (eye.height_m > push.low_m && eye.height_m < push.high_m) cloud_per_m += extinction(p, eye.up, eye.height_m, reach) / float(kEyeLooks);
  }
  float s = here.height_m < push.low_m ? length_rising(push.low_m - here.height_m, dot(flight.dir, here.up)) * 0.999 : 0.0;
  for (uint k = 0u; k < 20000u && tau < 8.0; ++k) {
    flight.s = s + 0.5 * push.step_m;
    here = place_on(flight);
    if (here.height_m > push.high_m) break;
    float sigma = extinction(flight.origin + flight.dir * flight.s, here.up, here.height_m, reach);
    // Far from every cloud by far more than its level changes within the stretch.
    float far_m = sigma > 0.0 ? push.step_m : clamp(-60.0 * (reach + 0.2), push.step_m, 60.0);
    tau += sigma * far_m;
    s += far_m;
  }
  steps.at[id] = Step(single * light_factor(f, 0) * ray.stretch * step_m, exp(-tau), cloud_sun_transmittance(stretch.dir * t), cloud_per_m);
}
