// How far a ray may go without meeting a cloud, from what is cheap to read.
#ifndef NEPHO_CLOUD_SEARCH_GLSL
#define NEPHO_CLOUD_SEARCH_GLSL
#include "clouds/cloud_density.glsl"

const float kLevelStep = 0.16;      // a level of -1 is about this many cells from a cloud, at least
const float kShapeReach = 1.15;     // most that billows add to a level, but for one place in three thousand
const float kBaseSlope = 0.04;      // steepest rise of a base that follows ground or weather
const int kPlaces = 8;              // readings of the weather map along a ray

// The stretches of the ray between the shells that hold all layers: [span.x, span.y] without the part [gap.x, gap.y] below
// them. entry_f_m2 is planet_f() at span.x, known from the shell itself where the ray enters through one: no large float is
// subtracted.
bool hull_span(vec3 dir, float far_m, out vec2 span, out vec2 gap, out float entry_f_m2) {
  PlanetView planet = CLOUD_PLANET;
  // Scaled height is up to 1.00336 times the geodetic one: the shells are taken that much apart.
  float low_m = CLOUD.hull_low_m - max(-CLOUD.hull_low_m, 0.0) * 0.0034 - 1.0, high_m = CLOUD.hull_high_m * 1.0034 + 1.0;
  gap = vec2(kFarDepth_m);
  entry_f_m2 = planet.camera_f_m2;
  vec2 outer, inner;
  if (!intersect_shell(planet, dir, high_m, outer) || outer.y <= 0.0) return false;
  span = vec2(max(outer.x, 0.0), min(outer.y, far_m));
  if (outer.x > 0.0) entry_f_m2 = high_m * (2.0 * planet.a_m + high_m);
  if (intersect_shell(planet, dir, low_m, inner) && inner.y > 0.0) {
    if (inner.x <= 0.0) {  // the camera is below the layers
      span.x = inner.y;
      entry_f_m2 = low_m * (2.0 * planet.a_m + low_m);
    } else {
      gap = inner;
    }
  }
  return span.x < span.y;
}

// Length of a ray over which height changes by dz, where it climbs by `climb` per metre and the Earth curves away below it.
float ray_over(float dz_m, float climb) { return 2.0 * dz_m / (climb + sqrt(climb * climb + 2.0 * dz_m / CLOUD_PLANET.a_m)); }

// Length of a ray before it can meet a layer that is `away_m` metres above it (above: whose base is that far over the point)
// or below it, where the ray climbs by `climb` and the layer's faces by at most `slope` per metre.
float ray_free(float away_m, bool above, float climb, float slope) {
  float bend = 2.0 * away_m / (1.01 * CLOUD_PLANET.a_m);
  float closing = slope + (above ? climb : -climb);
  float root = closing * closing + (above ? 1.03 * bend : -bend);
  if (root < 0.0 || (!above && closing <= 0.0)) return 1.0e9;  // the Earth curves away sooner than the ray sinks
  root = sqrt(root);
  return closing < 0.0 ? 0.97 * CLOUD_PLANET.a_m * (root - closing) : 2.0 * away_m / (closing + root);
}

// Highest level that billows and what the footprint hides can make of a column's. (The steep cut at the base says nothing
// about distance.)
float cloud_reach(uint l, float level, float need, float eta, float unknown) {
  return level + max(need - 1.0, 0.0) * smoothstep(0.03, 0.0, eta) + 
         kShapeReach * CLOUD.layers[l].shape_amount * smoothstep(0.0, 0.25, eta) * (1.0 - 0.75 * anvil_share(eta, CLOUD.layers[l].anvil_amount)) +
         2.6 * sqrt(unknown);
}

CloudWeather mix_weather(CloudWeather a, CloudWeather b, float u) {
  if (WEATHER == kWeatherUniform) {
    a.ground_m = mix(a.ground_m, b.ground_m, u);
    return CloudWeather(vec4(CLOUD.uniform_coverage), vec4(0.5, 0.0, 1.0, 0.0), GROUND ? a.ground_m : vec2(0.0));
  }
  return CloudWeather(mix(a.coverage, b.coverage, u), mix(a.properties, b.properties, u), mix(a.ground_m, b.ground_m, u));
}

#endif
