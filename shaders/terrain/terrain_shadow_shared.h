// Data and pure functions of terrain's shadows, for C++ and GLSL (docs/light.md, 'Terrain shadows').
#ifndef NEPHO_TERRAIN_TERRAIN_SHADOW_SHARED_H
#define NEPHO_TERRAIN_TERRAIN_SHADOW_SHARED_H
#include "common/region_map.h"
SHARED_BEGIN

// Heights of the ground above the ellipsoid in nested maps, kShadowTexels^2 a level, a layer each. Mip 0 has the heights;
// mip m > 0 has, per cell of 2^m texels, the highest ground of the cell and its eight neighbours, finer levels included: from
// anywhere in a cell nothing higher is met within a cell's width.
SHARED_CONST uint kShadowTexels = 256u;
SHARED_CONST uint kShadowMips = 7u;

struct TerrainShadowConstants {
  RegionMap map;
  float highest_m;  // ground of the whole map
};

// How far below the ground of a texel of this size the map of shadow heights follows shadows, m.
SHARED_FN float deepest_shade_m(float texel_m) { return min(2.0f * texel_m + 5.0f, 300.0f); }

// Share of a disc that stands above a straight horizon `clear` radii below its centre.
SHARED_FN float disc_share(float clear) {
  float x = clamp(clear, -1.0f, 1.0f);
  return 0.5f + (x * sqrt(max(1.0f - x * x, 0.0f)) + asin(x)) / kPi;
}

SHARED_END
#endif
