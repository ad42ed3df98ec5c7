// Sun's transmittance through the clouds at a point on or above the ground, by a short march (shadow maps come later).
#ifndef NEPHO_CLOUD_SHADOW_MARCH_GLSL
#define NEPHO_CLOUD_SHADOW_MARCH_GLSL
#include "clouds/cloud_density.glsl"

const int kShadowSteps = 8;

// p_cam: camera-relative point, m. 1 where nothing is between it and the sun; with the sun below the local horizon too
// (the light that does not arrive needs no shadow).
float cloud_sun_transmittance(vec3 p_cam) {
  PlanetView planet = CLOUD_PLANET;
  vec3 sun = frame.frame_data.key_dir;
  if (CLOUD.uniform_density > 0.0) return 1.0;  // a test's slab; without coverage there is no pass
  float height_m = geodetic_height(planet, p_cam);
  float climb = dot(geodetic_up(planet, p_cam), sun);
  if (climb <= 0.0) return 1.0;
  // Distance along the ray to a height above the point's own, over a sphere of radius a: exact enough at any sun height.
  float r = planet.a_m + height_m;
  float b = r * climb;
  float log2_pixel = log2(max(frame.frame_data.pixel_angle_rad * length(p_cam), 1.0));
  float tau = 0.0;
  for (uint k = 0u; k < CLOUD.caster_count; ++k) {
    uint l = CLOUD.casters[k];
    // Weather and bases are those where the ray meets the middle of the layer.
    float middle_m = max(CLOUD.layers[l].base_m + 0.5 * CLOUD.layers[l].thickness_m - height_m, 0.0);
    float c_middle = middle_m * (2.0 * r + middle_m);
    vec3 place = p_cam + sun * (c_middle / (b + sqrt(b * b + c_middle)));
    vec3 place_up = geodetic_up(planet, place);
    CloudWeather w = cloud_weather_at(place, place_up, log2_pixel);
    float base_m = cloud_base_m(l, w);
    float rise_to_base = max(base_m - height_m, 0.0), rise_to_top = max(base_m + CLOUD.layers[l].thickness_m - height_m, 0.0);
    float c0 = rise_to_base * (2.0 * r + rise_to_base), c1 = rise_to_top * (2.0 * r + rise_to_top);
    float t0 = c0 / (b + sqrt(b * b + c0)), t1 = min(c1 / (b + sqrt(b * b + c1)), t0 + 60.0e3);
    float step_m = (t1 - t0) / float(kShadowSteps);
    float log2_footprint = max(log2(max(0.5 * step_m, 1.0)), log2_pixel);
    float depth = 0.0;
    for (int i = 0; i < kShadowSteps && tau + depth < 8.0; ++i) {
      vec3 p = p_cam + sun * (t0 + (float(i) + 0.5) * step_m);
      vec3 up = geodetic_up(planet, p);
      float h = geodetic_height(planet, p);
      CloudColumn c = cloud_column(l, w, p, up, h, log2_footprint);
      float eta = cloud_eta(l, c, h);
      float unknown = c.unknown;
      float level = cloud_cell_level(l, c, p, up, h, clamp(eta, 0.0, 1.0), log2_footprint, unknown);
      level += cloud_shape_level(l, c, CloudChurn(vec3(0.0), vec3(0.0), vec3(0.0)), p, eta, log2_footprint, unknown);
      float sigma = cloud_medium(l, c.density, level, unknown, 0.04, eta, exp2(log2_footprint)).sigma_per_m;
      if (eta > 0.0 && eta < 1.0) depth += sigma * step_m;
    }
    tau += depth;
  }
  return exp(-tau);
}

#endif
