// Light inside the clouds: optical depth towards the sun, and the source terms of the march (docs/clouds.md, 'Light').
#ifndef NEPHO_CLOUD_LIGHT_GLSL
#define NEPHO_CLOUD_LIGHT_GLSL
#include "clouds/cloud_density.glsl"

// Optical depth from a point towards the sun by taps at growing distances, the far ones coarse. Slow fields are those
// of the point itself: the taps reach about two kilometres.
const int kSunTaps = 4;
const float kSunFirst_m = 48.0;
const float kSunGrowth = 2.7;

float cloud_sun_depth(vec3 p_cam, vec3 up, float height_m, CloudColumn column, float log2_footprint) {
  vec3 sun = frame.frame_data.key_dir;
  float climb = dot(up, sun);
  float depth = 0.0, from_m = 0.0, length_m = max(kSunFirst_m, 0.4 * exp2(log2_footprint));
  for (int i = 0; i < kSunTaps; ++i) {
    float d = from_m + 0.5 * length_m;
    float h = height_m + climb * d;
    float eta = (h - CLOUD.base_m) / CLOUD.thickness_m;
    if (eta >= 1.0 || eta <= -0.05) break;
    vec3 p = p_cam + sun * d;
    float log2_tap = max(log2_footprint, log2(0.5 * length_m));
    float unknown = column.unknown;
    float level = cloud_cell_level(column, p, up, h, eta, log2_tap, unknown);
    if (i < 3)
      level += cloud_shape_level(p, eta, log2_tap, unknown);
    else
      unknown += kShapeWeight * kShapeWeight;
    depth += cloud_extinction(level, unknown, 0.05, eta, exp2(log2_tap)) * length_m;
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
