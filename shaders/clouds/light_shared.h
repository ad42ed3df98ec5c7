// Data of the light inside clouds, for C++ and GLSL (docs/light.md).
#ifndef NEPHO_CLOUDS_LIGHT_SHARED_H
#define NEPHO_CLOUDS_LIGHT_SHARED_H
#include "clouds/path_shared.h"
SHARED_BEGIN

// The light that clouds scattered at least once is kept in cells that fan out from the camera: nodes over the picture times
// slices along each ray, from where the ray meets the first layer on. Slice i is first_m (1 + growth)^i long.
struct LightCells {
  uvec2 nodes;
  uint slices;       // a multiple of 32
  uint paths;        // through each cell
  uint path_step;    // from one to the next, all in turn: whose turns run out has seen directions of all kinds
  float first_m;
  float growth;
  float log2_ratio;  // log2(1 + growth)
  uint stride_px;    // of the pixels whose rays say which cells are seen
  float deepest;        // optical depth of the grid beyond which nothing is seen, through gaps that it does not know
  uint refresh_frames;  // in which each cell that has light gets a path more, once
  float smooth_m;      // cells share paths within this,
  float smooth_paths;  // and within so many free paths of the scaled medium
};

// The density grid: nested maps of columns, cut into slices of height within the bands that hold layers.
struct CloudGrid {
  RegionMap map;
  vec4 band_low_m;   // geodetic heights, lowest band first
  vec4 band_high_m;
  vec4 band_first;   // first slice
  vec4 band_slices;  // number of slices
  uint bands;
  uint texels;       // along a side of a level; even
  uint slices;       // of a level; even
  uint all_around;   // 1: it has what is far outside of the view, too
  vec2 shift;        // of the middle of each level from that of the map, in halves of its side; multiples of 4 / texels
};

struct CloudLightConstants {
  CloudGrid grid;
  RegionMap ground;      // of the ground's albedo and height
  LightCells cells;
  float forward_share;   // f: share of scattering taken as going straight on
  float wide_g;          // asymmetry of the rest
  float wide_albedo;     // single scattering albedo of the rest
  float forward_albedo;  // share of extinction that goes straight on: albedo * f
  uint seed;
  uint frame_index;
  vec3 moved_m;          // of the camera since the last frame, ECEF axes
  float keep;            // share of the weight that cells of the last frame keep; 0: there are none
  float most_weight;     // of a cell, in full sets of paths
  uint still;            // 1: cells lie where they lay
};

// Place along the slices of a point `s_m` beyond the ray's entry; slice i holds i..i+1.
SHARED_FN float light_slice(LightCells cells, float s_m) {
  return log2(1.0f + max(s_m, 0.0f) * cells.growth / cells.first_m) / cells.log2_ratio;
}

SHARED_FN float light_slice_m(LightCells cells, float slice) {
  return (exp2(slice * cells.log2_ratio) - 1.0f) * cells.first_m / cells.growth;
}

// How many cells are seen. In sequences: how many of them, and of the nodes on the ground, have no light yet (or little), and how many
// get a path more.
struct LightWork {
  uint count;
  uint fresh;
  uint refresh;
  uint ground_fresh;
  uint ground_refresh;
};

SHARED_CONST float kLightEnough = 0.5f;  // weight of a cell, in full sets of paths, from which on it is not traced in full

// Threads of a group of light_gather.comp; paths of a cell are spread over them in sequences.
SHARED_CONST uint kLightThreads = 64u;
SHARED_CONST uint kLightGroupsAcross = 32768u;  // of a dispatch, along x

// Threads that share the paths of a cell that has none yet; and groups for so many cells.
SHARED_FN uint light_threads(LightCells cells) { return min(cells.paths, kLightThreads); }
SHARED_FN uint light_groups(uint items, uint threads) {
  uint each = kLightThreads / threads;
  return (items + each - 1u) / each;
}

// Cells (2 x 2 x 2 voxels) around each over which the largest extinction is known; trilinear reads take a voxel of it.
SHARED_CONST uint kMostReach = 2u;
SHARED_CONST float kMostVoxels = 3.0f;

SHARED_CONST uint kLightSkyTexels = 32u;  // along both sides of the table of light_sky.comp

// Beam table: theta = pi u^2, u = 0..1 over kBeamTexels; rows of four orders.
SHARED_CONST uint kBeamTexels = 512u;
SHARED_CONST uint kBeamOrders = 8u;

SHARED_END
#endif
