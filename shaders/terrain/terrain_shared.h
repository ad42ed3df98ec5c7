// Layouts and index arithmetic of the terrain passes (docs/terrain.md).
#ifndef NEPHO_TERRAIN_SHARED_H
#define NEPHO_TERRAIN_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kTerrainQuads = 64u;                       // per side of a tile
SHARED_CONST uint kTerrainVertices = 65u * 65u + 2u * 64u;   // grid, then the coarser ring
SHARED_CONST uint kTerrainImageryTexels = 256u;              // per side, border included
SHARED_CONST uint kTerrainSlopeTexels = 128u;
SHARED_CONST uint kTerrainBorderTexels = 4u;                 // beyond the tile on each side, at mip 0
SHARED_CONST uint kTerrainImageryMips = 4u;
SHARED_CONST uint kTerrainSlopeMips = 3u;

// One tile to be drawn.
struct TerrainTile {
  uint slot;         // layer of the atlases, and place in the vertex buffer
  uint edges;        // kEdge... and kCorner... bits of src/terrain/tile_mesh.h: borders that take the coarser level's heights
  float texel_m;     // size of an imagery texel, m: geometric mean of both sides at the equator
  float morph;       // how much of its own shape the tile has: 0 the parent's, 1 all (src/terrain/tile_select.h)
  vec2 map_origin;   // north-west corner on the world map: u = (lon + 180) / 360, v = (90 - lat) / 180
  vec2 map_size;     // of the tile, in the same units
  vec4 edge_morph;   // north, east, south, west; corners excluded
  vec4 corner_morph; // north-west, north-east, south-east, south-west
  vec2 atlas_origin; // of the imagery: atlas coordinates are atlas_origin + uv * atlas_size (src/terrain/imagery_grid.h)
  vec2 atlas_size;
  float detail_log2; // imagery texels for one pixel of the source, log2: 0 and more
  float parts;       // 1: imagery texels are parts of a pixel, and the parent's colours are the same; else 0
  float slope_lod;   // log2 of imagery texels for one slope texel, negative
};

struct TerrainRasterPush {
  vec3 camera_hi_m;  // ECEF position of the camera in two floats
  vec3 camera_lo_m;
};

// Vertex that is drawn at a grid place (index = row * 65 + column): its own, or the ring's where the border is coarser.
// Only even border places have one in the ring; the others are not in the index buffer of a coarser edge.
SHARED_FN uint terrain_vertex(uint index, uint edges) {
  uint n = kTerrainQuads;
  uint column = index % (n + 1u);
  uint row = index / (n + 1u);
  bool west = column == 0u;
  bool east = column == n;
  bool north = row == 0u;
  bool south = row == n;
  if (!(west || east || north || south) || edges == 0u) return index;
  uint bit;
  if (north) bit = west ? 16u : (east ? 32u : 1u);
  else if (south) bit = west ? 128u : (east ? 64u : 4u);
  else bit = east ? 2u : 8u;
  if ((edges & bit) == 0u) return index;
  uint ring;
  if (north && !east) ring = column / 2u;
  else if (east && !south) ring = n / 2u + row / 2u;
  else if (south && !west) ring = n + (n - column) / 2u;
  else ring = 3u * n / 2u + (n - row) / 2u;
  return (n + 1u) * (n + 1u) + ring;
}

// How much of its own shape the tile has at a grid place: what tiles share there they move alike.
SHARED_FN float terrain_morph(uint index, float inner, vec4 edge, vec4 corner) {
  uint n = kTerrainQuads;
  uint column = index % (n + 1u);
  uint row = index / (n + 1u);
  bool west = column == 0u;
  bool east = column == n;
  if (row == 0u) return west ? corner.x : (east ? corner.y : edge.x);
  if (row == n) return west ? corner.w : (east ? corner.z : edge.z);
  return west ? edge.w : (east ? edge.y : inner);
}

// Coordinate of a place on a tile (uv 0..1 from its north-west corner) in its slopes.
SHARED_FN float terrain_slope_coordinate(float uv) {
  float border = float(kTerrainBorderTexels);
  float inner = float(kTerrainSlopeTexels) - 2.0f * border;
  return (border + uv * inner) / float(kTerrainSlopeTexels);
}

// Mip of the imagery's colours. `lod`: log2 of texels that a pixel's footprint covers; `coarsened`: the least mip. While
// the footprint is within one pixel of the source nothing is averaged, however many texels that is: bilinear between
// the source's pixels is their mean over a footprint of that size. Twice as large, all is averaged that it covers.
SHARED_FN float terrain_colour_lod(float lod, float detail_log2, float coarsened) {
  float beyond = max(lod - detail_log2, 0.0f);
  return clamp(min(lod, beyond * (detail_log2 + 1.0f)), coarsened, float(kTerrainImageryMips) - 1.0f);
}

// Linear value of an sRGB code 0..1 (IEC 61966-2-1).
SHARED_FN float terrain_linear(float code) {
  return code <= 0.04045f ? code / 12.92f : pow((code + 0.055f) / 1.055f, 2.4f);
}

SHARED_END
#endif
