// Data of the path tracer, for C++ and GLSL (docs/reference.md).
#ifndef NEPHO_CLOUDS_PATH_SHARED_H
#define NEPHO_CLOUDS_PATH_SHARED_H
#include "common/region_map.h"
SHARED_BEGIN

// Majorants of extinction: nested maps of columns around a place, each cut into slices of height within the bands that hold
// all layers. A texel holds the majorant, 1/m; or, where nothing is, -(1 + below + kBoundsRun * above): how many slices
// below it and above it are empty as well.
SHARED_CONST uint kBoundsTexels = 128u;  // along a side of a level
SHARED_CONST uint kBoundsSlices = 32u;   // of all bands together
SHARED_CONST uint kBoundsBands = 4u;
SHARED_CONST float kBoundsRun = 64.0f;

struct CloudBounds {
  RegionMap map;
  vec4 band_low_m;    // geodetic heights, lowest band first
  vec4 band_high_m;
  vec4 band_first;    // first slice
  vec4 band_slices;   // number of slices
  uint bands;
  float most_per_m;   // no extinction is larger; for what the map does not reach
};

// A ray of a table: what probes look along.
struct PathRay {
  vec3 origin;     // camera-relative, ECEF axes, m
  float spread;    // 0: along dir; 1: cosine-weighted over the hemisphere about dir
  vec3 dir;        // unit
  float pad;
};

// Which paths a round has: those of pixel (or ray) i are the items from plan[i].first_item to plan[i + 1].first_item, its
// samples from first_sample on.
struct PathPlan {
  uint first_item;
  uint first_sample;
};

struct PathPush {
  uint items;         // paths of this round
  uint pixels;        // or rays
  uint seed;
  uint width;         // of the picture, px
  uint subpixels;     // along a side of a pixel, of the surface's images
  float ground_albedo_scale;  // 1; 0 makes the ground black
  float wind_mps;     // over water
};

// What a path brought home, without air: that depends on distances and directions only, and is applied by another shader.
SHARED_CONST uint kPathSky = 0u;      // met nothing
SHARED_CONST uint kPathSurface = 1u;  // met the surface first
SHARED_CONST uint kPathCloud = 2u;    // + 0..3: met a cloud of this layer first
struct PathResult {
  vec3 sunlit;        // luminance of the key light's paths at the first vertex
  float first_m;      // distance to the first vertex
  vec3 weight;        // of the light that comes in where the path left for space; 0: it did not
  float first_weight; // of the path at its first vertex (1 but for rare corrections of a majorant)
  float escape_height_m;
  uint escape_up;     // vertical and direction there, packed by pack_direction()
  uint escape_dir;
  uint kind;
};

// What dispatches did, summed.
struct PathCounts {
  uint paths, vertices, density_reads, moves, overruns;  // overruns: extinction above its majorant
};

// Work that invocations share.
struct PathWork {
  uint next;      // path of the batch to begin next
  uint unfinished;  // invocations of the last dispatch that stopped in the middle of a path
  PathCounts counts;
};

// A path in the middle, as an invocation leaves it to the same one of the next dispatch. (Mesa's software driver ends every loop
// of an invocation after 65536 turns of all its loops together, wordlessly.)
struct PathLane {
  uint state;        // 0: no path
  uint item, pixel;
  uint random_state, random_increment;
  uint kind_and_flags;  // PathResult::kind; 256: from the camera still, 512: the second, 1024: one waits
  uint surface_xy;
  float first_m, first_weight;
  float s, end_m, left, shadow;
  vec3 origin, dir;     // of the flight
  vec3 weight, pending, next_dir, sunlit;
  vec3 wait_origin, wait_dir, wait_weight;
  float escaped;
  vec3 escape_weight;
  float escape_height_m;
  uint escape_up, escape_dir;
};

// Octahedral coordinates of a unit vector (Cigolle et al. 2014), 16 bit each.
SHARED_FN uint pack_direction(vec3 d) {
  float sum = abs(d.x) + abs(d.y) + abs(d.z);
  float x = d.x / sum, y = d.y / sum;
  if (d.z < 0.0f) {
    float u = (1.0f - abs(y)) * (x < 0.0f ? -1.0f : 1.0f);
    y = (1.0f - abs(x)) * (y < 0.0f ? -1.0f : 1.0f);
    x = u;
  }
  uint i = uint(clamp(x * 0.5f + 0.5f, 0.0f, 1.0f) * 65535.0f + 0.5f);
  uint j = uint(clamp(y * 0.5f + 0.5f, 0.0f, 1.0f) * 65535.0f + 0.5f);
  return i | (j << 16u);
}

SHARED_FN vec3 unpack_direction(uint word) {
  float x = float(word & 0xffffu) * (2.0f / 65535.0f) - 1.0f;
  float y = float(word >> 16u) * (2.0f / 65535.0f) - 1.0f;
  float z = 1.0f - abs(x) - abs(y);
  if (z < 0.0f) {
    float u = (1.0f - abs(y)) * (x < 0.0f ? -1.0f : 1.0f);
    y = (1.0f - abs(x)) * (y < 0.0f ? -1.0f : 1.0f);
    x = u;
  }
  return normalize(vec3(x, y, z));
}

// The table of the key light: u runs over the cosine mu of its zenith angle as sign sqrt |mu|, finest at the horizon.
SHARED_FN float unit_from_key_mu(float mu) { return 0.5f + 0.5f * (mu < 0.0f ? -sqrt(-mu) : sqrt(mu)); }
SHARED_FN float key_mu_from_unit(float u) {
  float s = 2.0f * u - 1.0f;
  return s * abs(s);
}
SHARED_CONST float kKeyLow_m = -1000.0f;  // heights of the table
SHARED_CONST float kKeyHigh_m = 30000.0f;
SHARED_CONST uint kKeyWidth = 512u, kKeyHeight = 64u;

SHARED_END
#endif
