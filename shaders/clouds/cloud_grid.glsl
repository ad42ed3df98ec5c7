// Extinction and optical depth towards the key light on a grid around the camera: nested maps of columns (region_map.h), cut
// into slices of height within the bands that hold layers. For light that is smooth; silhouettes are cloud_density.glsl's.
//
//   uniform CloudLightConstants as LIGHT; sampler3D grid_tex: r extinction (1/m), g optical depth
#ifndef NEPHO_CLOUD_GRID_GLSL
#define NEPHO_CLOUD_GRID_GLSL
#include "clouds/light_shared.h"
#include "clouds/flight.glsl"

// Band of a height, -1 between and beyond them; and the way to the next one above and below (kFar_m: there is none).
int grid_band(CloudBounds grid, float height_m, out float above_m, out float below_m) {
  int band = -1;
  above_m = kFar_m;
  below_m = kFar_m;
  for (uint b = 0u; b < grid.bands; ++b) {
    float low = grid.band_low_m[b], high = grid.band_high_m[b];
    if (height_m < low) above_m = min(above_m, low - height_m);
    else if (height_m >= high) below_m = min(below_m, height_m - high);
    else band = int(b);
  }
  return band;
}

// x extinction, y optical depth to the key light at a place inside a band; 0 beyond the last map.
vec2 grid_read(CloudBounds grid, int band, Place here) {
  vec2 xy = region_xy(grid.map, here.dir);
  // The finest level among whose texel centres the place lies.
  float widest = max(abs(xy.x), abs(xy.y)) * (float(kBoundsTexels) / float(kBoundsTexels - 1u));
  float level = max(floor(log2(max(widest / grid.map.half_m, 0.5))) + 1.0, 0.0);
  float levels = float(grid.map.levels);
  float low = grid.band_low_m[band], high = grid.band_high_m[band], slices = grid.band_slices[band];
  float z = clamp((here.height_m - low) / (high - low) * slices, 0.5, slices - 0.5) + grid.band_first[band];
  vec3 uvw = vec3(xy * (0.5 * exp2(-level) / grid.map.half_m) + 0.5, (min(level, levels - 1.0) * float(kBoundsSlices) + z) / (levels * float(kBoundsSlices)));
  return level < levels ? textureLod(grid_tex, uvw, 0.0).rg : vec2(0.0);
}

// Optical depth from anywhere to the key light, through all layers.
float grid_sun_depth(CloudBounds grid, vec3 p, vec3 sun) {
  Flight f = flight_from(p, sun);
  Place here = place_on(f);
  float above_m, below_m;
  int band = grid_band(grid, here.height_m, above_m, below_m);
  if (band < 0) {
    float climb = dot(here.up, sun);
    f.s = min(above_m < kFar_m ? length_rising(above_m + 0.5, climb) : kFar_m, below_m < kFar_m ? length_sinking(below_m + 0.5, climb) : kFar_m);
    if (f.s >= kFar_m) return 0.0;
    here = place_on(f);
    band = grid_band(grid, here.height_m, above_m, below_m);
  }
  return band >= 0 ? grid_read(grid, band, here).y : 0.0;
}

#endif
