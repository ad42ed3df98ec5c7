#version 460
#extension GL_GOOGLE_include_directive : require
// `nepho probe weather`: the map's values, coverage refined by the fields that are larger than cells.
#include "clouds/cloud_probe.glsl"
layout(set = 0, binding = 21, scalar) buffer Answers { vec4 answers[]; } answers;

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  vec3 p = CLOUD_CASE.p_cam;
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float height_m = geodetic_height(CLOUD_PLANET, p);
  float log2_footprint = log2(max(CLOUD_CASE.footprint_m, 1.0));
  CloudWeather w = cloud_weather_at(p, up, log2_footprint);
  vec4 coverage = w.coverage;
  vec4 done = vec4(0.0);
  for (uint l = 0u; l < LAYERS; ++l) {
    // Given the slow fields, cells cover the share Phi((z + slow) / cell_weight) of the surroundings.
    vec4 mine = CLOUD.layers[l].channel * (1.0 - done);
    if (dot(mine, vec4(1.0)) == 0.0) continue;
    CloudColumn c = cloud_column(l, w, p, up, height_m, log2_footprint);
    float value = dot(CLOUD.layers[l].channel, w.coverage);
    float wc = CLOUD.layers[l].cell_weight;
    float share = value <= 0.0 ? 0.0 : value >= 1.0 ? 1.0 : share_from_probit((probit_from_share(value) + c.slow) / sqrt(wc * wc + c.unknown));
    coverage = mix(coverage, vec4(share), mine);
    done += mine;
  }
  answers.answers[2u * id] = coverage;
  answers.answers[2u * id + 1u] = w.properties;
}
