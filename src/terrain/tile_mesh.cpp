#include "terrain/tile_mesh.h"

#include <cmath>
#include <glm/gtc/packing.hpp>

#include "base/error.h"
#include "terrain/terrain_shared.h"
#include "terrain/tile_select.h"

namespace nepho {

static_assert(shared::kTerrainQuads == kTileQuads && shared::kTerrainVertices == kTileVertices);
static_assert(sizeof(TileVertex) == 32);

namespace {
// Out of line on purpose: GCC 12.2 at -O2 vectorises x - double(float(x)) of two neighbours and forgets the rounding,
// so that the low part comes out as 0 (tests/terrain/tile_mesh_test.cpp shows it).
[[gnu::noinline]] float narrow(double v) { return static_cast<float>(v); }
}  // namespace

SplitVertex split(const dvec3& ecef_m) {
  const glm::vec3 hi(narrow(ecef_m.x), narrow(ecef_m.y), narrow(ecef_m.z));
  return {hi, glm::vec3(ecef_m - dvec3(hi))};
}

std::vector<double> vertex_lons_deg(const TileId& tile) {
  std::vector<double> out(kTileVerticesPerSide);
  const double step = vertex_spacing_deg(tile.level);
  for (uint32_t i = 0; i < kTileVerticesPerSide; ++i)
    out[i] = -180.0 + static_cast<double>(uint64_t{tile.x} * kTileQuads + i) * step;
  return out;
}

std::vector<double> vertex_lats_deg(const TileId& tile) {
  std::vector<double> out(kTileVerticesPerSide);
  const double step = vertex_spacing_deg(tile.level);
  for (uint32_t j = 0; j < kTileVerticesPerSide; ++j)
    out[j] = 90.0 - static_cast<double>(uint64_t{tile.y} * kTileQuads + j) * step;
  return out;
}

void grid_positions(std::span<const double> lat_deg, std::span<const double> lon_deg, const double* height_m,
                    const Ellipsoid& ellipsoid, dvec3* out) {
  struct Direction {
    double sin, cos;
  };
  std::vector<Direction> lon(lon_deg.size());
  for (size_t i = 0; i < lon.size(); ++i) {
    const double a = rad_from_deg(canonical_lon_deg(lon_deg[i]));
    lon[i] = {std::sin(a), std::cos(a)};
  }
  const double ratio2 = (ellipsoid.b_m / ellipsoid.a_m) * (ellipsoid.b_m / ellipsoid.a_m);
  const double e2 = 1.0 - ratio2;
  for (size_t j = 0; j < lat_deg.size(); ++j) {
    const double phi = rad_from_deg(lat_deg[j]);
    // At a pole all longitudes are one point, to the bit.
    const bool pole = std::abs(lat_deg[j]) >= 90.0;
    const double s = pole ? std::copysign(1.0, phi) : std::sin(phi);
    const double c = pole ? 0.0 : std::cos(phi);
    const double n = ellipsoid.a_m / std::sqrt(1.0 - e2 * s * s);
    for (size_t i = 0; i < lon.size(); ++i) {
      const double h = height_m[j * lon.size() + i];
      const double r = (n + h) * c;
      out[j * lon.size() + i] =
          pole ? dvec3(0.0, 0.0, (n * ratio2 + h) * s) : dvec3(r * lon[i].cos, r * lon[i].sin, (n * ratio2 + h) * s);
    }
  }
}

GridPlace ring_place(uint32_t r) {
  const uint32_t half = kTileQuads / 2, side = r / half, step = 2 * (r % half);
  switch (side) {
    case 0:
      return {step, 0};
    case 1:
      return {kTileQuads, step};
    case 2:
      return {kTileQuads - step, kTileQuads};
    default:
      return {0, kTileQuads - step};
  }
}

namespace {

/// Positions of the parent's triangles at every grid place of a tile: its vertices at even places, which are also those
/// of the ring; between them the middle of an edge, or of the north-east to south-west diagonal.
std::vector<dvec3> parent_surface(const TileId& tile, std::span<const double> lats, std::span<const double> lons,
                                  const HeightSampler& ground, const Ellipsoid& ellipsoid) {
  constexpr size_t n = kTileVerticesPerSide, m = kTileQuads / 2 + 1;
  std::vector<double> lat(m), lon(m), height(m * m);
  for (size_t i = 0; i < m; ++i) {
    lat[i] = lats[2 * i];
    lon[i] = lons[2 * i];
  }
  ground.heights_m(lat, lon, tile.level > 0 ? tile.level - 1 : 0, height.data());
  std::vector<dvec3> coarse(m * m), out(n * n);
  grid_positions(lat, lon, height.data(), ellipsoid, coarse.data());
  for (size_t j = 0; j < n; ++j)
    for (size_t i = 0; i < n; ++i) {
      const size_t i0 = i / 2, j0 = j / 2, i1 = (i + 1) / 2, j1 = (j + 1) / 2;
      out[j * n + i] = i0 == i1 && j0 == j1 ? coarse[j0 * m + i0] : 0.5 * (coarse[j0 * m + i1] + coarse[j1 * m + i0]);
    }
  return out;
}

}  // namespace

std::vector<TileVertex> tile_vertices(const TileId& tile, const HeightSampler& ground, const Ellipsoid& ellipsoid) {
  const std::vector<double> lats = vertex_lats_deg(tile), lons = vertex_lons_deg(tile);
  std::vector<double> heights(kTileGridVertices);
  ground.heights_m(lats, lons, tile.level, heights.data());
  std::vector<dvec3> positions(kTileGridVertices);
  grid_positions(lats, lons, heights.data(), ellipsoid, positions.data());
  const std::vector<dvec3> parent = parent_surface(tile, lats, lons, ground, ellipsoid);
  std::vector<TileVertex> out(kTileVertices);
  for (uint32_t i = 0; i < kTileGridVertices; ++i) {
    out[i].place = split(positions[i]);
    if (tile.level == 0) continue;  // nothing is coarser
    const glm::vec3 way(parent[i] - positions[i]);
    out[i].to_parent_m = {glm::packHalf2x16(glm::vec2(way.x, way.y)), glm::packHalf2x16(glm::vec2(way.z, 0.0f))};
  }
  for (uint32_t r = 0; r < kTileRingVertices; ++r) {
    const GridPlace at = ring_place(r);
    out[kTileGridVertices + r].place = split(parent[at.row * kTileVerticesPerSide + at.column]);
  }
  return out;
}

uint32_t drawn_vertex(uint32_t column, uint32_t row, uint8_t edges) {
  return shared::terrain_vertex(row * kTileVerticesPerSide + column, edges);
}

float drawn_morph(const SelectedTile& tile, uint32_t column, uint32_t row) {
  const auto& e = tile.edge_morph;
  const auto& c = tile.corner_morph;
  return shared::terrain_morph(row * kTileVerticesPerSide + column, tile.morph, glm::vec4(e[0], e[1], e[2], e[3]),
                               glm::vec4(c[0], c[1], c[2], c[3]));
}

std::vector<dvec3> drawn_positions(const SelectedTile& tile, std::span<const TileVertex> vertices) {
  NEPHO_ASSERT_OP(vertices.size(), ==, size_t{kTileVertices});
  constexpr uint32_t n = kTileVerticesPerSide;
  std::vector<dvec3> out(kTileGridVertices);
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) {
      const TileVertex& v = vertices[drawn_vertex(i, j, tile.edges)];
      const glm::vec2 xy = glm::unpackHalf2x16(v.to_parent_m[0]), z = glm::unpackHalf2x16(v.to_parent_m[1]);
      const double left = 1.0 - static_cast<double>(drawn_morph(tile, i, j));
      out[j * n + i] = dvec3(v.place.hi) + dvec3(v.place.lo) + left * dvec3(glm::vec3(xy, z.x));
    }
  for (uint32_t k = 1; k < kTileQuads; k += 2) {
    const auto between = [&](uint32_t at, uint32_t step) { out[at] = 0.5 * (out[at - step] + out[at + step]); };
    if (tile.edges & kEdgeNorth) between(k, 1);
    if (tile.edges & kEdgeSouth) between(kTileQuads * n + k, 1);
    if (tile.edges & kEdgeWest) between(k * n, n);
    if (tile.edges & kEdgeEast) between(k * n + kTileQuads, n);
  }
  return out;
}

TileTopologies make_topologies() {
  TileTopologies out;
  for (uint32_t edges = 0; edges < 16; ++edges) {
    const auto vertex = [&](uint32_t i, uint32_t j) {
      if (((j == 0 && (edges & kEdgeNorth)) || (j == kTileQuads && (edges & kEdgeSouth))) && (i & 1)) --i;
      if (((i == 0 && (edges & kEdgeWest)) || (i == kTileQuads && (edges & kEdgeEast))) && (j & 1)) --j;
      return j * kTileVerticesPerSide + i;
    };
    const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
      if (a == b || b == c || c == a) return;
      out.indices.insert(out.indices.end(), {a, b, c});
    };
    for (uint32_t quarter = 0; quarter < 4; ++quarter) {
      TileTopologies::Range& range = out.quarters[edges][quarter];
      range.first = static_cast<uint32_t>(out.indices.size());
      constexpr uint32_t kHalf = kTileQuads / 2;
      const uint32_t i0 = (quarter & 1) * kHalf, j0 = (quarter >> 1) * kHalf;
      for (uint32_t j = j0; j < j0 + kHalf; ++j)
        for (uint32_t i = i0; i < i0 + kHalf; ++i) {
          const uint32_t nw = vertex(i, j), ne = vertex(i + 1, j), sw = vertex(i, j + 1), se = vertex(i + 1, j + 1);
          // Where two coarser edges meet in the south-east, the usual diagonal would leave a triangle without area.
          const bool other_diagonal =
              i == kTileQuads - 1 && j == kTileQuads - 1 && (edges & kEdgeSouth) && (edges & kEdgeEast);
          triangle(nw, sw, other_diagonal ? se : ne);
          triangle(other_diagonal ? nw : ne, other_diagonal ? se : sw, other_diagonal ? ne : se);
        }
      range.count = static_cast<uint32_t>(out.indices.size()) - range.first;
    }
  }
  return out;
}

}  // namespace nepho
