#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "geo/geodetic.h"
#include "geo/lonlat_tiles.h"
#include "terrain/height_sampler.h"

namespace nepho {

/// Vertices of a tile: a 65 x 65 grid, row 0 northernmost, column 0 westernmost, and after it the ring of every other
/// vertex of the border at the heights of the next coarser level (128, clockwise from the north-west corner). An edge
/// that touches a coarser tile is drawn with the ring's vertices alone: then both tiles have the very same vertices
/// there, and no crack can open.
inline constexpr uint32_t kTileVerticesPerSide = kTileQuads + 1;
inline constexpr uint32_t kTileGridVertices = kTileVerticesPerSide * kTileVerticesPerSide;
inline constexpr uint32_t kTileRingVertices = 2 * kTileQuads;
inline constexpr uint32_t kTileVertices = kTileGridVertices + kTileRingVertices;

/// Which parts of a tile's border take the coarser level's heights.
inline constexpr uint32_t kEdgeNorth = 1, kEdgeEast = 2, kEdgeSouth = 4, kEdgeWest = 8;
inline constexpr uint32_t kCornerNorthWest = 16, kCornerNorthEast = 32, kCornerSouthEast = 64, kCornerSouthWest = 128;

/// ECEF position in two floats: hi + lo is good to 2^-48 of the Earth's radius (0.1 um).
struct SplitVertex {
  glm::vec3 hi, lo;
};
SplitVertex split(const dvec3& ecef_m);

/// A vertex as the GPU has it: its place, and the way from there to the parent's surface (ECEF, m, three half floats:
/// both ends of the way are exact to 0.05 % of its length, which is about a pixel when it is gone).
struct TileVertex {
  SplitVertex place;
  std::array<uint32_t, 2> to_parent_m{};
};

/// Longitudes of the tile's columns, west to east, and latitudes of its rows, north to south, degrees; exact in double.
std::vector<double> vertex_lons_deg(const TileId& tile);
std::vector<double> vertex_lats_deg(const TileId& tile);

/// ECEF position of every grid place: the same bits for the same place and height whichever tile asks; poles and
/// antimeridian too. `height_m` and `out` row by row.
void grid_positions(std::span<const double> lat_deg, std::span<const double> lon_deg, const double* height_m,
                    const Ellipsoid& ellipsoid, dvec3* out);

/// Grid place (column, row) of ring vertex `r`.
struct GridPlace {
  uint32_t column, row;
};
GridPlace ring_place(uint32_t r);

/// A tile's kTileVertices vertices: the grid at the tile's level, and the ring at the coarser one.
std::vector<TileVertex> tile_vertices(const TileId& tile, const HeightSampler& ground, const Ellipsoid& ellipsoid);

/// Index of the vertex that is drawn at a grid place (shaders/terrain/terrain_shared.h does the same).
uint32_t drawn_vertex(uint32_t column, uint32_t row, uint8_t edges);

struct SelectedTile;
/// How much of its own shape a tile has at a grid place, 0..1 (the shader does the same).
float drawn_morph(const SelectedTile& tile, uint32_t column, uint32_t row);
/// ECEF position of every grid place as drawn, row by row, m: own and parent's shape blended, borders that touch
/// coarser tiles at their heights. On those borders odd places, which have no vertex, lie between their neighbours.
std::vector<dvec3> drawn_positions(const SelectedTile& tile, std::span<const TileVertex> vertices);

/// Triangles, counter-clockwise from outside, for each of the 16 sets of coarser edges (kEdgeNorth..kEdgeWest), as grid
/// indices row * 65 + column: border vertices that a coarser neighbour lacks are left out. Sorted by quarter of the
/// tile (north-west, north-east, south-west, south-east), so that hidden ones need not be drawn.
struct TileTopologies {
  struct Range {
    uint32_t first = 0, count = 0;
  };
  std::vector<uint32_t> indices;
  Range quarters[16][4];
  /// All four quarters, which follow each other.
  Range whole(uint32_t edges) const {
    const auto& q = quarters[edges];
    return {q[0].first, q[0].count + q[1].count + q[2].count + q[3].count};
  }
};
TileTopologies make_topologies();

}  // namespace nepho
