// Light inside the clouds: optical depth towards the sun, and the source terms of the march (docs/clouds.md, 'Light').
#ifndef NEPHO_CLOUD_LIGHT_GLSL
#define NEPHO_CLOUD_LIGHT_GLSL
#include "clouds/cloud_density.glsl"

// Optical depth from a point of layer l towards the sun by taps at growing distances, the far ones coarse. Slow fields are
// those of the point itself: the taps reach about two kilometres (further in layers of larger cells).
const int kSunTaps = 4;
const float kSunGrowth = 2.7;

float cloud_sun_depth(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  vec3 sun = frame.frame_data.key_dir;
  float climb = dot(up, sun);
  float size = sqrt(CLOUD.layers[l].cell_size_m / 2500.0);
  float depth = 0.0, from_m = 0.0, length_m = max(48.0 * size, 0.4 * exp2(log2_footprint));
  // The way out of the layer, so that the last stretch counts as far as it is inside: whole ones would show as rings.
  float rise_m = clamp(height_m - c.base_m, 0.0, CLOUD.layers[l].thickness_m);
  float out_m = (climb > 0.0 ? CLOUD.layers[l].thickness_m - rise_m : rise_m) / max(abs(climb), 1.0e-3);
  for (int i = 0; i < kSunTaps; ++i) {
    float inside_m = min(length_m, out_m - from_m);
    if (inside_m <= 0.0) break;
    float sigma_per_m;
    if (CLOUD.uniform_density > 0.0) {
      sigma_per_m = CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
    } else {
      float d = from_m + 0.5 * inside_m;
      float h = height_m + climb * d;
      float eta = clamp(cloud_eta(l, c, h), 0.0, 0.9999);
      vec3 p = p_cam + sun * d;
      float log2_tap = max(log2_footprint, log2(0.5 * length_m));
      float unknown = c.unknown;
      float level = cloud_cell_level(l, c, p, up, h, eta, log2_tap, unknown);
      level += cloud_shape_level(l, c, CloudChurn(vec3(0.0), vec3(0.0), vec3(0.0)), p, eta, log2_tap, unknown);
      sigma_per_m = cloud_medium(l, c.density, level, unknown, 0.05, eta, exp2(log2_tap)).sigma_per_m;
    }
    depth += sigma_per_m * inside_m;
    from_m += length_m;
    length_m *= kSunGrowth;
  }
  return depth;
}

// Scattering orders beyond the first, as two wide lobes whose extinction is scaled along the view ray (view) and towards
// the sun (sun): light that was scattered forward is not lost. Chosen against the slab table of docs/clouds.md.
struct CloudOctave { float gain, view, sun, lobe; };
const CloudOctave kOctaves[2] = CloudOctave[2](CloudOctave(2.1, 0.45, 0.26, 0.312), CloudOctave(2.7, 0.20, 0.065, 0.097));

#endif
