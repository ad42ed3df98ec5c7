#version 460
#extension GL_GOOGLE_include_directive : require
// `nepho probe column`: vertical optical depth of every layer over a point, mean over the footprint, and where it is.
#include "clouds/cloud_probe.glsl"
struct Answer { vec4 optical_depth; float base_m, top_m; };
layout(set = 0, binding = 21, scalar) buffer Answers { Answer answers[]; } answers;
const int kSamples = 40;          // of a layer's thickness
const float kLeast_per_m = 1e-5;  // less is no cloud

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  vec3 p = CLOUD_CASE.p_cam;
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float height_m = geodetic_height(CLOUD_PLANET, p);
  float log2_footprint = log2(max(CLOUD_CASE.footprint_m, 1.0));
  CloudWeather w = cloud_weather_at(p, up, log2_footprint);
  Answer answer = Answer(vec4(0.0), 1.0e30, -1.0e30);
  for (uint l = 0u; l < LAYERS; ++l) {
    CloudColumn c = cloud_column(l, w, p, up, height_m, log2_footprint);
    float step_m = CLOUD.layers[l].thickness_m / float(kSamples), sum = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      float h = c.base_m + (float(i) + 0.5) * step_m;
      float mean = CLOUD.uniform_density > 0.0 ? CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m
                                               : cloud_medium_at(l, c, p + up * (h - height_m), up, h, log2_footprint).mean_per_m;
      sum += mean;
      if (mean > kLeast_per_m) {
        answer.base_m = min(answer.base_m, h - 0.5 * step_m);
        answer.top_m = max(answer.top_m, h + 0.5 * step_m);
      }
    }
    answer.optical_depth[CLOUD.layers[l].slot] = sum * step_m;
  }
  answers.answers[id] = answer;
}
