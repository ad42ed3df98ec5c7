#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: the shadow maps at points beside a fine march through the density at full detail.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
#include "clouds/shadow_map.glsl"
struct Answer { float truth, by_map, sigma_per_m; uint steps; };
layout(scalar, set = 0, binding = 20) readonly buffer PointBlock { vec3 at[]; } points;
layout(scalar, set = 0, binding = 21) writeonly buffer AnswerBlock { Answer at[]; } answers;
// step_m 0: no march
layout(push_constant, scalar) uniform PushBlock { uint count; float step_m; } push;

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
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  vec3 p = points.at[id];
  Answer answer = Answer(1.0, cloud_sun_transmittance(p), 0.0, 0u);
  Flight f = flight_from(p, frame.frame_data.key_dir);
  Place here = place_on(f);
  float reach, far_m = 0.0, low_m = SHADOW.hull_low_m - 1.0, high_m = 1.0034 * SHADOW.hull_high_m + 1.0;
  answer.sigma_per_m = extinction(p, here.up, here.height_m, reach);
  if (push.step_m > 0.0) {
    float s = here.height_m < low_m ? length_rising(low_m - here.height_m, dot(f.dir, here.up)) * 0.999 : 0.0, tau = 0.0;
    for (uint i = 0u; i < 60000u && tau < 12.0; ++i) {
      f.s = s + 0.5 * push.step_m;
      here = place_on(f);
      if (here.height_m > high_m) break;
      float sigma = extinction(f.origin + f.dir * f.s, here.up, here.height_m, reach);
      // Far from every cloud by far more than its level changes within the stretch.
      float step_m = sigma > 0.0 ? push.step_m : clamp(-30.0 * (reach + 0.2), push.step_m, 30.0);
      tau += sigma * step_m;
      s += step_m;
      ++answer.steps;
    }
    answer.truth = exp(-tau);
  }
  answers.at[id] = answer;
}
