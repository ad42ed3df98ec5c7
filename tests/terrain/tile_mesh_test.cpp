#include "terrain/tile_mesh.h"

#include <doctest/doctest.h>

#include <cstring>
#include <glm/gtc/packing.hpp>
#include <map>
#include <set>

#include "terrain/tile_builder.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// A border vertex as drawn, under its place on the grid of a level deeper than any drawn one.
using Place = std::pair<uint64_t, uint64_t>;
constexpr uint32_t kCommonLevel = 20;

Place place_of(const TileId& t, uint32_t column, uint32_t row) {
  const uint32_t shift = kCommonLevel - t.level;
  const uint64_t i = (uint64_t{t.x} * kTileQuads + column) << shift, j = (uint64_t{t.y} * kTileQuads + row) << shift;
  const uint64_t width = (2 * kTileQuads) * (uint64_t{1} << kCommonLevel),
                 height = kTileQuads * (uint64_t{1} << kCommonLevel);
  if (j == 0 || j == height) return {0, j};  // a pole
  return {i % width, j};
}

bool same_bits(const SplitVertex& a, const SplitVertex& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// All vertices that a tile's triangles use on its border, by place.
std::map<Place, SplitVertex> border_of(const SelectedTile& s, const HeightSampler& ground,
                                       const TileTopologies& topologies) {
  const std::vector<TileVertex> vertices = tile_vertices(s.tile, ground, Ellipsoid::wgs84());
  std::map<Place, SplitVertex> out;
  const TileTopologies::Range range = topologies.whole(s.edges & 15u);
  for (uint32_t i = range.first; i < range.first + range.count; ++i) {
    const uint32_t column = topologies.indices[i] % 65, row = topologies.indices[i] / 65;
    if (column % 64 && row % 64) continue;
    const TileVertex& v = vertices[drawn_vertex(column, row, s.edges)];
    // As the shader: what is left of the way to the parent's surface, on top of the place.
    const float left = 1.0f - drawn_morph(s, column, row);
    const glm::vec3 way(glm::unpackHalf2x16(v.to_parent_m[0]), glm::unpackHalf2x16(v.to_parent_m[1]).x);
    out[place_of(s.tile, column, row)] = {v.place.hi, v.place.lo + left * way};
  }
  return out;
}

/// Both tiles' border vertices on the stretch that they share must be the same places with the same bits.
void check_watertight(const TerrainView& view, const HeightSampler& ground, size_t& shared_vertices,
                      size_t& level_steps) {
  const ImagerySampler imagery({}, ground);
  const TileBuilder builder(ground, imagery, Ellipsoid::wgs84());
  TileMetaCache metas(builder);
  const TileTopologies topologies = make_topologies();
  std::map<Place, std::pair<SplitVertex, TileId>> seen;
  std::map<TileId, std::map<Place, SplitVertex>> borders;
  const std::vector<SelectedTile> tiles = select_tiles(view, metas);
  for (const SelectedTile& s : tiles) {
    borders[s.tile] = border_of(s, ground, topologies);
    for (const auto& [place, vertex] : borders[s.tile]) {
      const auto [at, fresh] = seen.try_emplace(place, vertex, s.tile);
      if (fresh) continue;
      ++shared_vertices;
      if (at->second.second.level != s.tile.level) ++level_steps;
      REQUIRE(same_bits(at->second.first, vertex));
    }
  }
  // No T-junction: on the edge towards an equal or coarser neighbour that is drawn, every vertex is the neighbour's
  // too.
  std::set<TileId> drawn;
  for (const SelectedTile& s : tiles) drawn.insert(s.tile);
  for (const SelectedTile& s : tiles)
    for (int side = 0; side < 4; ++side) {
      const int dx[] = {0, 1, 0, -1}, dy[] = {-1, 0, 1, 0};
      auto other = tile_neighbour(s.tile, dx[side], dy[side]);
      if (!other) continue;
      if (!drawn.contains(*other)) other = tile_parent(*other);
      if (!other || !drawn.contains(*other)) continue;
      for (uint32_t i = 0; i <= 64; ++i) {
        const Place p =
            side % 2 == 0 ? place_of(s.tile, i, side == 0 ? 0 : 64) : place_of(s.tile, side == 1 ? 64 : 0, i);
        REQUIRE(borders[s.tile].contains(p) == borders[*other].contains(p));
      }
    }
}

}  // namespace

TEST_CASE("vertices are within 0.2 um of the geodetic position") {
  const double lat[] = {-90.0, -33.3, 0.0, 71.25, 90.0}, lon[] = {-180.0, -12.5, 0.0, 99.0, 180.0};
  std::vector<double> h(25, 4321.5);
  std::vector<dvec3> p(25);
  grid_positions(lat, lon, h.data(), Ellipsoid::wgs84(), p.data());
  for (size_t j = 0; j < 5; ++j)
    for (size_t i = 0; i < 5; ++i) {
      const SplitVertex v = split(p[j * 5 + i]);
      const dvec3 sum = dvec3(v.hi) + dvec3(v.lo);
      CHECK(glm::length(sum - ecef_from_geodetic(Geodetic::from_degrees(lat[j], lon[i], 4321.5))) < 2e-7);
    }
}

TEST_CASE("every topology covers the tile once, counter-clockwise, without the odd vertices of coarser edges") {
  const TileTopologies t = make_topologies();
  for (uint32_t edges = 0; edges < 16; ++edges) {
    double area = 0.0;
    const auto [first, count] = t.whole(edges);
    for (uint32_t i = first; i < first + count; i += 3) {
      double x[3], y[3];
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t column = t.indices[i + k] % 65, row = t.indices[i + k] / 65;
        x[k] = column;
        y[k] = -static_cast<double>(row);  // north up
        const bool odd_row_edge =
            ((row == 0 && (edges & kEdgeNorth)) || (row == 64 && (edges & kEdgeSouth))) && column % 2;
        const bool odd_column_edge =
            ((column == 0 && (edges & kEdgeWest)) || (column == 64 && (edges & kEdgeEast))) && row % 2;
        REQUIRE(!odd_row_edge);
        REQUIRE(!odd_column_edge);
      }
      const double twice = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
      REQUIRE(twice > 0.0);
      area += twice / 2;
    }
    CHECK(area == 64.0 * 64.0);
  }
}

TEST_CASE("ring places and the shader's index of them agree") {
  for (uint32_t r = 0; r < kTileRingVertices; ++r) {
    const GridPlace at = ring_place(r);
    CHECK(drawn_vertex(at.column, at.row, 255) == kTileGridVertices + r);
    CHECK(drawn_vertex(at.column, at.row, 0) == at.row * 65 + at.column);
  }
  CHECK(drawn_vertex(0, 0, kEdgeNorth | kEdgeWest) == 0);  // a corner follows its own bit
}

TEST_CASE("tiles that touch share their border vertices to the bit, across levels, poles and antimeridian") {
  const HeightSampler ground({rough_world()}, false, nullptr);
  size_t shared_vertices = 0, level_steps = 0;
  const Extent2D extent{640, 360};
  for (const auto& [lat, lon, height, pitch] : {std::tuple{35.0, 138.0, 6000.0, -10.0},
                                                {89.99, 10.0, 20000.0, -40.0},
                                                {-90.0, 0.0, 6000.0, -5.0},
                                                {-16.9, 179.999, 9000.0, -20.0},
                                                {10.0, -180.0, 400000.0, -60.0},
                                                {0.0, 30.0, 36e6, -90.0}})
    check_watertight(
        view_at(Geodetic::from_degrees(lat, lon, height), Attitude::from_degrees(80.0, pitch), 60.0, extent), ground,
        shared_vertices, level_steps);
  CHECK(shared_vertices > 10000);
  CHECK(level_steps > 1000);
}
