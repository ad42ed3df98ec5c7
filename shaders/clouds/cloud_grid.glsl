// Extinction and optical depth towards the key light on a grid around the camera: nested maps of columns (region_map.h), cut
// into slices of height within the bands that hold layers. For light that is smooth; silhouettes are cloud_density.glsl's.
//
//   uniform CloudLightConstants as LIGHT; sampler3D grid_tex: r extinction (1/m), g optical depth
#ifndef NEPHO_CLOUD_GRID_GLSL
#define NEPHO_CLOUD_GRID_GLSL
#include "clouds/light_shared.h"
#include "clouds/flight.glsl"

// Band of a height, -1 between and beyond them; and the way to the next one above and below (kFar_m: there is none).
int grid_band(CloudGrid grid, float height_m, out float above_m, out float below_m) {
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

// Where a place is on the grid: z from the first slice of a level on, and the finest level that has it kMostVoxels inside (or
// beyond the last one).
struct GridPlace {
  vec2 xy;
  float z, level;
};

GridPlace grid_place(CloudGrid grid, int band, Place here) {
  GridPlace at;
  at.xy = region_xy(grid.map, here.dir);
  float widest = max(abs(at.xy.x), abs(at.xy.y)) * (1.0 / (1.0 - 2.0 * (kMostVoxels + 1.0) / float(grid.texels)));
  at.level = max(floor(log2(max(widest / grid.map.half_m, 0.5))) + 1.0, 0.0);
  float low = grid.band_low_m[band], high = grid.band_high_m[band], slices = grid.band_slices[band];
  at.z = clamp((here.height_m - low) / (high - low) * slices, 0.5, slices - 0.5) + grid.band_first[band];
  return at;
}

// x extinction, y optical depth to the key light; 0 beyond the last map.
vec2 grid_read_at(CloudGrid grid, GridPlace at) {
  float levels = float(grid.map.levels);
  vec3 uvw = vec3(at.xy * (0.5 * exp2(-at.level) / grid.map.half_m) + 0.5, (min(at.level, levels - 1.0) * float(grid.slices) + at.z) / (levels * float(grid.slices)));
  return at.level < levels ? textureLod(grid_tex, uvw, 0.0).rg : vec2(0.0);
}

vec2 grid_read(CloudGrid grid, int band, Place here) { return grid_read_at(grid, grid_place(grid, band, here)); }

// Optical depth from anywhere to the key light, through all layers.
float grid_sun_depth(CloudGrid grid, vec3 p, vec3 sun) {
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
