#version 460
#extension GL_GOOGLE_include_directive : require
// `nepho probe density`: density of every layer at a point, and the extinction of all.
#include "clouds/cloud_probe.glsl"
struct Answer { vec4 density; float extinction_per_m; };
layout(set = 0, binding = 21, scalar) buffer Answers { Answer answers[]; } answers;

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  vec3 p = CLOUD_CASE.p_cam;
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float height_m = geodetic_height(CLOUD_PLANET, p);
  float log2_footprint = log2(max(CLOUD_CASE.footprint_m, 1.0));
  CloudWeather w = cloud_weather_at(p, up, log2_footprint);
  Answer answer = Answer(vec4(0.0), 0.0);
  for (uint l = 0u; l < LAYERS; ++l) {
    float eta = (height_m - cloud_base_m(l, w)) / CLOUD.layers[l].thickness_m;
    if (eta <= 0.0 || eta >= 1.0) continue;
    float sigma = CLOUD.layers[l].extinction_per_m;
    float mean = 0.0;
    if (CLOUD.uniform_density > 0.0) {
      mean = CLOUD.uniform_density * sigma;
    } else {
      CloudColumn c = cloud_column(l, w, p, up, height_m, log2_footprint);
      mean = cloud_medium_at(l, c, p, up, height_m, log2_footprint).mean_per_m;
    }
    answer.density[CLOUD.layers[l].slot] = mean / (CLOUD.extinction_unit_per_m);
    answer.extinction_per_m += mean;
  }
  answers.answers[id] = answer;
}
