// Sun's transmittance through the clouds at a point on or above the ground, by a short march (shadow maps come later).
#ifndef NEPHO_CLOUD_SHADOW_MARCH_GLSL
#define NEPHO_CLOUD_SHADOW_MARCH_GLSL
#include "clouds/cloud_density.glsl"

const int kShadowSteps = 8;

// p_cam: camera-relative point, m. 1 where nothing is between it and the sun; with the sun below the local horizon too
// (the light that does not arrive needs no shadow).
float cloud_sun_transmittance(vec3 p_cam) {
  PlanetView planet = frame.frame_data.planet;
  vec3 sun = frame.frame_data.key_dir;
  if (CLOUD.uniform_density > 0.0) return 1.0;  // a test's slab; without coverage there is no pass
  float height_m = geodetic_height(planet, p_cam);
  float climb = dot(geodetic_up(planet, p_cam), sun);
  float top_m = CLOUD.base_m + CLOUD.thickness_m;
  if (climb <= 0.0 || height_m >= top_m) return 1.0;
  // Distance along the ray to a height above the point's own, over a sphere of radius a: exact enough at any sun height.
  float r = planet.a_m + height_m;
  float b = r * climb;
  float rise_to_base = max(CLOUD.base_m - height_m, 0.0), rise_to_top = top_m - height_m;
  float c0 = rise_to_base * (2.0 * r + rise_to_base), c1 = rise_to_top * (2.0 * r + rise_to_top);
  float t0 = c0 / (b + sqrt(b * b + c0)), t1 = min(c1 / (b + sqrt(b * b + c1)), t0 + 60.0e3);
  float step_m = (t1 - t0) / float(kShadowSteps);
  float log2_footprint = log2(max(0.5 * step_m, frame.frame_data.pixel_angle_rad * length(p_cam)));
  float tau = 0.0;
  for (int i = 0; i < kShadowSteps && tau < 8.0; ++i) {
    vec3 p = p_cam + sun * (t0 + (float(i) + 0.5) * step_m);
    float h = geodetic_height(planet, p);
    float eta = (h - CLOUD.base_m) / CLOUD.thickness_m;
    if (eta <= -0.05 || eta >= 1.0) continue;
    vec3 up = geodetic_up(planet, p);
    CloudColumn column = cloud_column(p, up, h, log2_footprint);
    float unknown = column.unknown;
    float level = cloud_cell_level(column, p, up, h, eta, log2_footprint, unknown);
    level += cloud_shape_level(p, eta, log2_footprint, unknown);
    tau += cloud_extinction(level, unknown, 0.04, eta, exp2(log2_footprint)) * step_m;
  }
  return exp(-tau);
}

#endif
