// Light on its way into the clouds: optical depth towards the key light, and what of its beam reaches the eye by one scattering
// that turns it, after any number that hardly do (docs/light.md).
#ifndef NEPHO_CLOUD_LIGHT_GLSL
#define NEPHO_CLOUD_LIGHT_GLSL
#include "clouds/cloud_density.glsl"
#include "clouds/cloud_grid.glsl"
#include "common/sampling.h"

// Near the point the density itself is asked, at distances that grow; from there on the grid knows. Slow fields are those of
// the point.
const int kSunTaps = 4;
const float kSunGrowth = 1.8;
const float kFirstTap_m = 20.0;

// Schneider's set (2015), for comparison: five equal stretches whose looks wind outwards within a cone, and one three times as long,
// on its axis. Together they reach as far as the others do.
const int kConeTaps = 6;
const float kConeFar = 3.0;     // lengths of the last stretch
const float kConeSpread = 0.25; // radius of the cone at distance 1

// From the axis, at distance 1.
vec3 cone_aside(vec3 axis, int i) {
  float radius = i < kConeTaps - 1 ? kConeSpread * sqrt((float(i) + 0.5) / float(kConeTaps - 1)) : 0.0, phi = 2.399963 * float(i);
  vec3 t = tangent_of(axis);
  return radius * (t * cos(phi) + cross(axis, t) * sin(phi));
}

// Length of a stretch of the cone's, of the first of `count` that grow so much.
float cone_length(int i, float first_m, float growth, int count) {
  float reach_m = first_m * (pow(growth, float(count)) - 1.0) / (growth - 1.0);
  return reach_m / (float(kConeTaps - 1) + kConeFar) * (i < kConeTaps - 1 ? 1.0 : kConeFar);
}

// Of a slab (a test of the march): mean extinction of a stretch that rises by rise_m, with its middle at eta.
float slab_extinction(uint l, float eta, float rise_m) {
  float rise = rise_m / CLOUD.layers[l].thickness_m, eta0 = eta - 0.5 * rise, eta1 = eta + 0.5 * rise;
  float inside = clamp(max(eta0, eta1), 0.0, 1.0) - clamp(min(eta0, eta1), 0.0, 1.0);
  float share = abs(rise) > 1.0e-6 ? inside / abs(rise) : (eta >= 0.0 && eta < 1.0 ? 1.0 : 0.0);
  return share * CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
}

// Optical depth from a point of a cloud of layer l towards the sun.
float cloud_sun_depth(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  vec3 sun = frame.frame_data.key_dir;
  float climb = dot(up, sun);
  float depth = 0.0, from_m = 0.0, first_m = max(kFirstTap_m, 0.4 * exp2(log2_footprint)), length_m = first_m;
  int i = 0;
  do {
    if (CONE) length_m = cone_length(i, first_m, kSunGrowth, kSunTaps);
    float d = from_m + 0.5 * length_m;
    vec3 way = CONE ? sun + cone_aside(sun, i) : sun;
    float h = height_m + (CONE ? dot(up, way) : climb) * d;
    float sigma_per_m = 0.0;
    if (CLOUD.uniform_density > 0.0) {
      sigma_per_m = slab_extinction(l, cloud_eta(l, c, h), climb * length_m);
    } else {
      sigma_per_m = cloud_medium_at(l, c, p_cam + way * d, up, h, max(log2_footprint, log2(0.4 * length_m))).sigma_per_m;
    }
    depth += sigma_per_m * length_m;
    from_m += length_m;
    length_m *= kSunGrowth;
  } while (++i < (CONE ? kConeTaps : kSunTaps));
  return depth + grid_sun_depth(light_data.data.grid, p_cam + sun * from_m, sun).x;
}

// The same by half as many reads, for pictures that are not fine. What changes slowly along the way to the sun is read at two
// places for all taps, and small noise at one: within what a tap stands for it is the same, or so different that only its variance
// counts.
const float kSunNear = 1.2, kSunFar = 8.0;  // where: lengths of the first tap's stretch
const int kSunDetailed = 2;                     // taps that know small noise

float quick_sun_depth(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  vec3 sun = frame.frame_data.key_dir;
  float climb = dot(up, sun);
  float first_m = max(kFirstTap_m, 0.4 * exp2(log2_footprint));
  float depth = 0.0, from_m = 0.0, length_m = first_m;
  float near_m = kSunNear * first_m, far_m = kSunFar * first_m, near_cell = 0.0, far_cell = 0.0, near_unknown = 0.0, far_unknown = 0.0;
  float near_detail = 0.0, detail_unknown = 0.0;
  CloudChurn churn = CloudChurn(vec3(0.0), vec3(0.0), vec3(0.0));
  if (CLOUD.uniform_density <= 0.0) {
    vec3 near = p_cam + sun * near_m, far = p_cam + sun * far_m;
    float near_h = height_m + climb * near_m, far_h = height_m + climb * far_m, eta = clamp(cloud_eta(l, c, near_h), 0.0, 1.0);
    near_cell = cloud_cell_field(l, c, near, up, near_h, max(log2_footprint, log2(0.4 * first_m)), near_unknown);
    far_cell = cloud_cell_field(l, c, far, up, far_h, max(log2_footprint, log2(2.0 * first_m)), far_unknown);
    churn = cloud_churn(l, near, up, eta, log2_footprint);
    near_detail = cloud_detail_level(l, c, churn, near, eta, max(log2_footprint, log2(0.5 * first_m)), detail_unknown);
  }
  int i = 0;
  do {
    if (CONE) length_m = cone_length(i, first_m, kSunGrowth, kSunTaps);
    float d = from_m + 0.5 * length_m;
    vec3 way = CONE ? sun + cone_aside(sun, i) : sun;
    float h = height_m + (CONE ? dot(up, way) : climb) * d, eta = cloud_eta(l, c, h);
    float sigma_per_m = 0.0;
    if (CLOUD.uniform_density > 0.0) {
      sigma_per_m = slab_extinction(l, eta, climb * length_m);
    } else if (eta > 0.0 && eta < 1.0) {
      float log2_tap = max(log2_footprint, log2(0.4 * length_m)), u = (d - near_m) / (far_m - near_m);
      float unknown = c.unknown + mix(near_unknown, far_unknown, clamp(u, 0.0, 1.0));
      float level = mix(near_cell, far_cell, u) - cell_threshold(cloud_need(l, c, eta), c.probit);
      level += cloud_shape_level(l, c, churn, p_cam + way * d, eta, log2_tap, unknown);
      float weight = (kDetailWeight * kDetailWeight + kFineWeight * kFineWeight) * CLOUD.layers[l].detail_amount * CLOUD.layers[l].detail_amount;
      unknown += i < kSunDetailed ? detail_unknown : weight;
      level += i < kSunDetailed ? near_detail : 0.0;
      sigma_per_m = cloud_medium(l, c.density, level, unknown, 0.0, eta, exp2(log2_tap)).sigma_per_m;
    }
    depth += sigma_per_m * length_m;
    from_m += length_m;
    length_m *= kSunGrowth;
  } while (++i < (CONE ? kConeTaps : kSunTaps));
  return depth + grid_sun_depth(light_data.data.grid, p_cam + sun * from_m, sun).x;
}

// For octaves, which have no grid:
// Optical depth from a point of layer l towards the sun by taps at growing distances, the far ones coarse. Slow fields are
// those of the point itself: the taps reach about two kilometres (further in layers of larger cells).
const int kOctaveTaps = 4;
const float kOctaveGrowth = 2.7;

float octave_sun_depth(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  vec3 sun = frame.frame_data.key_dir;
  float climb = dot(up, sun);
  float size = sqrt(CLOUD.layers[l].cell_size_m / 2500.0);
  float first_m = max(48.0 * size, 0.4 * exp2(log2_footprint));
  float depth = 0.0, from_m = 0.0, length_m = first_m;
  // The way out of the layer, so that the last stretch counts as far as it is inside: whole ones would show as rings.
  float rise_m = clamp(height_m - c.base_m, 0.0, CLOUD.layers[l].thickness_m);
  float out_m = (climb > 0.0 ? CLOUD.layers[l].thickness_m - rise_m : rise_m) / max(abs(climb), 1.0e-3);
  for (int i = 0; i < (CONE ? kConeTaps : kOctaveTaps); ++i) {
    if (CONE) length_m = cone_length(i, first_m, kOctaveGrowth, kOctaveTaps);
    float inside_m = min(length_m, out_m - from_m);
    if (inside_m <= 0.0) break;
    float sigma_per_m;
    if (CLOUD.uniform_density > 0.0) {
      sigma_per_m = CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
    } else {
      float d = from_m + 0.5 * inside_m;
      vec3 way = CONE ? sun + cone_aside(sun, i) : sun;
      float h = height_m + (CONE ? dot(up, way) : climb) * d;
      float eta = clamp(cloud_eta(l, c, h), 0.0, 0.9999);
      vec3 p = p_cam + way * d;
      float log2_tap = max(log2_footprint, log2(0.5 * length_m));
      float unknown = c.unknown;
      float level = cloud_cell_level(l, c, p, up, h, eta, log2_tap, unknown);
      level += cloud_shape_level(l, c, CloudChurn(vec3(0.0), vec3(0.0), vec3(0.0)), p, eta, log2_tap, unknown);
      sigma_per_m = cloud_medium(l, c.density, level, unknown, 0.05, eta, exp2(log2_tap)).sigma_per_m;
    }
    depth += sigma_per_m * inside_m;
    from_m += length_m;
    length_m *= kOctaveGrowth;
  }
  return depth;
}

// Sum over the orders k of exp(-tau) (a tau)^k / k! beam[k], where a is the share of extinction that goes straight on; what is
// left of the light beyond the last order goes with it.
float beam_sum(vec4 beam0, vec4 beam1, float forward_albedo, float tau) {
  float x = forward_albedo * tau, term = exp(-tau), rest = exp(-(1.0 - forward_albedo) * tau), sum = 0.0;
  for (int k = 0; k < 8; ++k) {
    sum += term * (k < 4 ? beam0[k] : beam1[k - 4]);
    rest -= term;
    term *= x / float(k + 1);
  }
  return sum + max(rest, 0.0) * beam1[3];
}

#endif
