#version 460
#extension GL_GOOGLE_include_directive : require
// For random columns all over the globe: the least probit of local coverage under which a layer's column counts as covered.
// Its distribution is the layer's own relation between threshold and coverage (docs/clouds.md, 'Coverage').
#include "common/frame.h"
#include "common/noise.glsl"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
layout(push_constant, scalar) uniform Push { uint layer; uint count; float footprint_m; } push;
layout(set = 0, binding = 20, scalar) buffer Out { float probits[]; } critical;

const int kSamples = 40;

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= push.count) return;
  PlanetView planet = CLOUD_PLANET;
  vec3 h = hash3(ivec3(int(id), 17, 4), 1 << 24, 99u);
  float z = 2.0 * (float(id) + h.x) / float(push.count) - 1.0;  // stratified by area
  float angle = 2.0 * kPi * h.y;
  vec3 up = vec3(sqrt(1.0 - z * z) * vec2(cos(angle), sin(angle)), z);
  // The point of the ellipsoid whose normal is `up`, from the frame's camera at the centre of the Earth.
  float b = planet.a_m / planet.a_over_b;
  vec3 p = vec3(up.xy * planet.a_m * planet.a_m, up.z * b * b) / sqrt(planet.a_m * planet.a_m * dot(up.xy, up.xy) + b * b * up.z * up.z);
  uint l = push.layer;
  CloudWeather w = CloudWeather(vec4(0.5), vec4(0.5, 0.0, 1.0, 0.0), vec2(0.0));
  float log2_footprint = log2(push.footprint_m);
  CloudColumn c = cloud_column(l, w, p, up, 0.0, log2_footprint);
  float field[kSamples], spread = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    float eta = (float(i) + 0.5) / float(kSamples);
    float height_m = c.base_m + eta * CLOUD.layers[l].thickness_m;
    float unknown = c.unknown;
    field[i] = cloud_full_field(l, c, p + up * height_m, up, height_m, eta, log2_footprint, unknown);
    spread = unknown;
  }
  float low = -6.0, high = 6.0;
  for (int step = 0; step < 14; ++step) {
    float probit = 0.5 * (low + high), depth = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      float eta = (float(i) + 0.5) / float(kSamples);
      float level = field[i] - cell_threshold(cloud_need(l, c, eta), probit);
      depth += cloud_medium(l, 1.0, level, spread, 0.0, eta, push.footprint_m).mean_per_m;
    }
    depth *= CLOUD.layers[l].thickness_m / float(kSamples);
    if (depth > CLOUD.layers[l].cover_optical_depth) high = probit; else low = probit;
  }
  critical.probits[id] = 0.5 * (low + high);
}
