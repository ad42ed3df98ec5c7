// Extinction and optical depth towards the key light on a grid around the camera: nested maps of columns (region_map.h), cut
// into slices of height within the bands that hold layers. For light that is smooth; silhouettes are cloud_density.glsl's.
//
//   uniform CloudLightConstants as LIGHT; sampler3D most_tex: the largest extinction around
//   (cloud_grid_most.comp); sampler3D grid_tex: r mean extinction (1/m); optical depths to the key light: g of the
//   mean, b as scaled light meets it, a the same for what scatters there
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
  float inner = 1.0 - 2.0 * (kMostVoxels + 1.0) / float(grid.texels);
  vec2 half_m = max(at.xy / (inner + grid.shift), -at.xy / (inner - grid.shift));  // that a level needs
  at.level = max(floor(log2(max(max(half_m.x, half_m.y) / grid.map.half_m, 0.5))) + 1.0, 0.0);
  float low = grid.band_low_m[band], high = grid.band_high_m[band], slices = grid.band_slices[band];
  at.z = clamp((here.height_m - low) / (high - low) * slices, 0.5, slices - 0.5) + grid.band_first[band];
  return at;
}

// The texel's four; 0 beyond the last map.
vec4 grid_read_at(CloudGrid grid, GridPlace at) {
  float levels = float(grid.map.levels);
  vec3 uvw = vec3(at.xy * (0.5 * exp2(-at.level) / grid.map.half_m) - 0.5 * grid.shift + 0.5, (min(at.level, levels - 1.0) * float(grid.slices) + at.z) / (levels * float(grid.slices)));
  return at.level < levels ? textureLod(grid_tex, uvw, 0.0) : vec4(0.0);
}

vec4 grid_read(CloudGrid grid, int band, Place here) { return grid_read_at(grid, grid_place(grid, band, here)); }

// How far the largest extinction around a place holds along a ray that climbs by `climb`, and that extinction, 1/m. Beyond the
// last map: nothing, as far as the band goes.
float grid_most(CloudGrid grid, int band, Place here, float climb, inout float reach) {
  GridPlace at = grid_place(grid, band, here);
  if (at.level >= float(grid.map.levels)) return 0.0;
  float voxel_m = 2.0 * grid.map.half_m / float(grid.texels) * exp2(at.level);
  float slice_m = (grid.band_high_m[band] - grid.band_low_m[band]) / grid.band_slices[band];
  ivec3 cell = ivec3((at.xy / voxel_m + 0.5 * float(grid.texels) * (1.0 - grid.shift)) * 0.5, (at.level * float(grid.slices) + at.z) * 0.5);
  reach = min(reach, kMostVoxels * min(voxel_m * inversesqrt(max(1.0 - climb * climb, 1.0e-4)), slice_m / max(abs(climb), 1.0e-3)));
  return texelFetch(most_tex, cell, 0).r;
}

// The way along a ray to the end of the band it is in, or over the gap to the next one; kFar_m: it leaves them all.
float grid_leap(CloudGrid grid, int band, float height_m, float above_m, float below_m, float climb) {
  if (band >= 0)
    return climb > 0.0 ? length_rising(grid.band_high_m[band] - height_m + 0.5, climb) : length_sinking(height_m - grid.band_low_m[band] + 0.5, climb);
  return min(above_m < kFar_m ? length_rising(above_m + 0.5, climb) : kFar_m, below_m < kFar_m ? length_sinking(below_m + 0.5, climb) : kFar_m);
}

// Optical depths from anywhere to the key light, through all layers: of the mean, and as scaled light meets it. In clear air the
// grid does not say: on along the ray to where it does.
const int kClearSteps = 40;
vec2 grid_sun_depth(CloudGrid grid, vec3 p, vec3 sun) {
  Flight f = flight_from(p, sun);
  GridPlace at = GridPlace(vec2(0.0), 0.0, 0.0);
  bool known = false;
  float reach;
  int i = 0;
  do {  // condition last: a software device turns a loop once more for one at its head
    Place here = place_on(f);
    float above_m, below_m, climb = dot(here.up, sun);
    int band = grid_band(grid, here.height_m, above_m, below_m);
    reach = grid_leap(grid, band, here.height_m, above_m, below_m, climb);
    known = band >= 0 && grid_most(grid, band, here, climb, reach) > 0.0;
    if (known) at = grid_place(grid, band, here);
    f.s += max(reach, 1.0);
  } while (!known && reach < kFar_m && ++i < kClearSteps);
  return known ? grid_read_at(grid, at).yz : vec2(0.0);
}

#endif
