#include "terrain/tile_mesh.h"

#include <cmath>

#include "base/error.h"
#include "terrain/terrain_shared.h"

namespace nepho {

static_assert(shared::kTerrainQuads == kTileQuads && shared::kTerrainVertices == kTileVertices);
static_assert(sizeof(SplitVertex) == 24);

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

std::vector<SplitVertex> tile_vertices(const TileId& tile, const HeightSampler& ground, const Ellipsoid& ellipsoid,
                                       std::span<const double> own_height_m) {
  NEPHO_ASSERT_OP(own_height_m.size(), ==, size_t{kTileGridVertices});
  const std::vector<double> lats = vertex_lats_deg(tile), lons = vertex_lons_deg(tile);
  std::vector<dvec3> positions(kTileGridVertices);
  grid_positions(lats, lons, own_height_m.data(), ellipsoid, positions.data());
  std::vector<SplitVertex> out(kTileVertices);
  for (uint32_t i = 0; i < kTileGridVertices; ++i) out[i] = split(positions[i]);

  const uint32_t coarser = tile.level > 0 ? tile.level - 1 : 0;
  // Two rows and two columns of places; each is a grid of its own for the sampler.
  const auto fill = [&](std::span<const double> lat, std::span<const double> lon) {
    std::vector<double> h(lat.size() * lon.size());
    ground.heights_m(lat, lon, coarser, h.data());
    std::vector<dvec3> p(h.size());
    grid_positions(lat, lon, h.data(), ellipsoid, p.data());
    return p;
  };
  const double north_south[] = {lats.front(), lats.back()}, west_east[] = {lons.front(), lons.back()};
  const std::vector<dvec3> rows = fill(north_south, lons), columns = fill(lats, west_east);
  for (uint32_t r = 0; r < kTileRingVertices; ++r) {
    const GridPlace at = ring_place(r);
    const bool on_row = at.row == 0 || at.row == kTileQuads;
    out[kTileGridVertices + r] = split(on_row ? rows[(at.row == 0 ? 0 : kTileVerticesPerSide) + at.column]
                                              : columns[at.row * 2 + (at.column == 0 ? 0 : 1)]);
  }
  return out;
}

uint32_t drawn_vertex(uint32_t column, uint32_t row, uint8_t edges) {
  return shared::terrain_vertex(row * kTileVerticesPerSide + column, edges);
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
