#version 460
#extension GL_GOOGLE_include_directive : require
// `nepho probe column`: vertical optical depth of every layer over a point, mean over the footprint, and where it is.
#include "clouds/cloud_probe.glsl"
struct Answer { vec4 optical_depth; float base_m, top_m; };
layout(set = 0, binding = 21, scalar) buffer Answers { Answer answers[]; } answers;
const int kSamples = 40;          // of a layer's thickness
const float kLeast_per_m = 1e-5;  // less is no cloud

// A footprint larger than this is a square of smaller ones: what it hides of the fields is known too roughly otherwise.
const float kSubFootprint = 0.45;    // of the smallest cells
const float kSubFootprint_m = 2000.0;
const int kMostAside = 6;

void add_column(vec3 p, float footprint_m, float share, inout Answer answer) {
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float height_m = geodetic_height(CLOUD_PLANET, p);
  float log2_footprint = log2(max(footprint_m, 1.0));
  CloudWeather w = cloud_weather_at(p, up, log2_footprint);
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
    answer.optical_depth[CLOUD.layers[l].slot] += share * sum * step_m;
  }
}

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  vec3 p = CLOUD_CASE.p_cam;
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  vec3 east = normalize(cross(abs(up.z) < 0.99 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), up)), north = cross(up, east);
  float footprint_m = CLOUD_CASE.footprint_m;
  float cell_m = CLOUD.layers[0].cell_size_m;
  for (uint l = 1u; l < LAYERS; ++l) cell_m = min(cell_m, CLOUD.layers[l].cell_size_m);
  int aside = clamp(int(ceil(footprint_m / min(kSubFootprint * cell_m, kSubFootprint_m))), 1, kMostAside);
  float side_m = footprint_m / float(aside), share = 1.0 / float(aside * aside);
  Answer answer = Answer(vec4(0.0), 1.0e30, -1.0e30);
  for (int k = 0; k < aside * aside; ++k) {
    vec2 at = vec2(float(k % aside) + 0.5, float(k / aside) + 0.5) * side_m - 0.5 * footprint_m;
    add_column(p + east * at.x + north * at.y, side_m, share, answer);
  }
  answers.answers[id] = answer;
}
