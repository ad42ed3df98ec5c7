#version 460
#extension GL_GOOGLE_include_directive : require
// Majorants of extinction, one level of the nested map: a column of slices each invocation. A level inside takes the largest of
// the finer level's; elsewhere the density itself is asked at four places of the texel, with footprints of half its side: the
// highest level that what such a footprint hides can make of it decides. Tails beyond that are few; the tracer's estimators stay
// unbiased where extinction exceeds a majorant, as long as it is not zero there.
#include "clouds/path_shared.h"
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
layout(scalar, set = 0, binding = 20) uniform BoundsBlock { CloudBounds data; } bounds;
layout(set = 0, binding = 21, r32f) uniform image3D out_bounds;
layout(push_constant, scalar) uniform PushBlock { uint level; uint flat_bounds; } push;

const float kTail = 3.2;       // standard deviations of what a footprint hides that are reckoned with
const float kSlack = 0.06;     // change of the level's resolved part within a footprint

float largest_of(uint l, CloudColumn c, vec3 dir, float low_m, float high_m, float log2_footprint) {
  float thickness = CLOUD.layers[l].thickness_m;
  float eta0 = (low_m - c.base_m) / thickness, eta1 = (high_m - c.base_m) / thickness;
  if (eta1 <= 0.0 || eta0 >= 1.0) return 0.0;
  eta0 = clamp(eta0, 0.0, 1.0);
  eta1 = clamp(eta1, 0.0, 1.0);
  float middle = 0.5 * (eta0 + eta1);
  float full = 0.0;
  for (int i = 0; i < 3; ++i) full = max(full, density_profile(CLOUD.layers[l].profile, mix(eta0, eta1, 0.5 * float(i))));
  full *= 1.03 * CLOUD.layers[l].extinction_per_m * c.density;
  if (CLOUD.uniform_density > 0.0) return CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
  if (push.flat_bounds != 0u) return full;
  // Where the slice asks least.
  float widest = exp2(-1.0 / CLOUD.layers[l].altering_bias);
  float least = 1.0e9;
  for (int i = 0; i < 4; ++i) {
    float eta = i < 3 ? mix(max(eta0, 0.02), max(eta1, 0.02), 0.5 * float(i)) : clamp(widest, max(eta0, 0.02), max(eta1, 0.02));
    least = min(least, cell_threshold(cloud_need(l, c, eta), c.probit));
  }
  // A slice may be thicker than the texel's half is wide.
  log2_footprint = max(log2_footprint, log2(0.6 * (high_m - low_m)));
  float height_m = c.base_m + middle * thickness;
  vec3 p = point_at(CLOUD_PLANET, dir, height_m);
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float unknown = c.unknown;
  float level = cloud_cell_field(l, c, p, up, height_m, log2_footprint, unknown) - least;
  CloudChurn churn = cloud_churn(l, p, up, middle, log2_footprint);
  // Billows are weaker at the base than the slice's middle says; their largest weight within it counts for what is hidden.
  level += cloud_shape_level(l, c, churn, p, middle, log2_footprint, unknown);
  float detail = CLOUD.layers[l].detail_amount;
  unknown += detail * detail * (kDetailWeight * kDetailWeight + kFineWeight * kFineWeight);
  float most = level + kTail * sqrt(unknown) + kSlack;
  if (most <= 0.0) return 0.0;
  // All or nothing: where extinction exceeds a majorant weights grow with every collision.
  return full;
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, ivec2(kBoundsTexels)))) return;
  uint level = push.level;
  float half_m = region_half_m(bounds.data.map, level);
  float texel_m = 2.0 * half_m / float(kBoundsTexels);
  float log2_footprint = log2(0.5 * texel_m);
  int first = int(level * kBoundsSlices);
  int quarter = int(kBoundsTexels) / 4;
  bool inner = level > 0u && all(greaterThanEqual(at, ivec2(quarter))) && all(lessThan(at, ivec2(3 * quarter)));
  for (uint b = 0u; b < bounds.data.bands; ++b) {
    int slices = int(bounds.data.band_slices[b]), base = int(bounds.data.band_first[b]);
    float step_m = (bounds.data.band_high_m[b] - bounds.data.band_low_m[b]) / float(slices);
    for (int i = 0; i < slices; ++i) imageStore(out_bounds, ivec3(at, first + base + i), vec4(0.0));
    if (inner) {
      ivec2 child = (at - quarter) * 2;
      for (int i = 0; i < slices; ++i) {
        float most = 0.0;
        for (int k = 0; k < 4; ++k)
          most = max(most, imageLoad(out_bounds, ivec3(child + ivec2(k & 1, k >> 1), first - int(kBoundsSlices) + base + i)).r);
        imageStore(out_bounds, ivec3(at, first + base + i), vec4(most));
      }
    } else {
      vec3 dirs[4];
      CloudColumn columns[4];
      float low_m = bounds.data.band_low_m[b];
      // A base that follows ground or weather differs within the texel.
      float slope_m = GROUND || WEATHER != kWeatherUniform ? min(0.04 * texel_m, 400.0) : 0.5;
      for (uint l = 0u; l < LAYERS; ++l) {
        for (int k = 0; k < 4; ++k) {
          vec2 xy = (vec2(at) + 0.25 + 0.5 * vec2(k & 1, k >> 1)) * texel_m - half_m;
          dirs[k] = region_direction(bounds.data.map, xy);
          vec3 foot = point_at(CLOUD_PLANET, dirs[k], low_m);
          vec3 up = geodetic_up(CLOUD_PLANET, foot);
          columns[k] = cloud_column(l, cloud_weather_at(foot, up, log2_footprint), foot, up, low_m, log2_footprint);
        }
        for (int i = 0; i < slices; ++i) {
          float from_m = low_m + float(i) * step_m, most = 0.0;
          for (int k = 0; k < 4; ++k)
            most = max(most, largest_of(l, columns[k], dirs[k], from_m - slope_m, from_m + step_m + slope_m, log2_footprint));
          ivec3 voxel = ivec3(at, first + base + i);
          if (most > 0.0) imageStore(out_bounds, voxel, vec4(imageLoad(out_bounds, voxel).r + most));
        }
      }
    }
  }
}
