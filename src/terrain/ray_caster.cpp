#include "terrain/ray_caster.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/parallel.h"

namespace nepho {

namespace {
/// Indices of a run: a row of a quarter.
constexpr uint32_t kRunIndices = 3 * kTileQuads;
}  // namespace

std::optional<double> ray_triangle(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& dir) {
  // Volumes spanned by the ray and each edge: of one sign where the ray passes inside. Two triangles compute the same
  // number, but for its sign, for the edge they share.
  const double u = glm::dot(dir, glm::cross(c, b)), v = glm::dot(dir, glm::cross(a, c)),
               w = glm::dot(dir, glm::cross(b, a));
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return std::nullopt;
  const dvec3 n = glm::cross(b - a, c - a);
  const double along = glm::dot(dir, n);
  if (along == 0.0) return std::nullopt;
  return glm::dot(a, n) / along;
}

void RayCaster::Box::hold(const dvec3& p) {
  low = glm::min(low, p);
  high = glm::max(high, p);
}

std::optional<double> RayCaster::Box::entry(const dvec3& inverse) const {
  double enter = 0.0, leave = 1e300;
  for (int k = 0; k < 3; ++k) {
    // A hair wider: rounding must not cut off a triangle that lies in the box's side.
    const double margin = 1e-9 * std::max(std::abs(low[k]), std::abs(high[k])) + 1e-9;
    double a = (low[k] - margin) * inverse[k], b = (high[k] + margin) * inverse[k];
    if (a > b) std::swap(a, b);
    enter = std::max(enter, a);
    leave = std::min(leave, b);
  }
  if (enter > leave) return std::nullopt;
  return enter;
}

RayCaster::RayCaster(const dvec3& origin_ecef_m, std::span<const SelectedTile> tiles, const Positions& positions)
    : origin_(origin_ecef_m), topologies_(make_topologies()), tiles_(tiles.size()) {
  parallel_for(tiles.size(), [&](size_t i) {
    const SelectedTile& from = tiles[i];
    Tile& to = tiles_[i];
    to.id = from.tile;
    to.positions = positions(from);
    NEPHO_ASSERT_OP(to.positions.size(), ==, size_t{kTileGridVertices});
    for (dvec3& p : to.positions) p -= origin_;
    for (uint32_t quarter = 0; quarter < 4; ++quarter) {
      if (!(from.quarters & (1u << quarter))) continue;
      const TileTopologies::Range range = topologies_.quarters[from.edges & 15u][quarter];
      for (uint32_t at = 0; at < range.count; at += kRunIndices) {
        Run run{range.first + at, std::min(kRunIndices, range.count - at), {}};
        for (uint32_t k = 0; k < run.count; ++k) run.box.hold(to.positions[topologies_.indices[run.first + k]]);
        to.box.hold(run.box.low);
        to.box.hold(run.box.high);
        to.runs.push_back(run);
      }
    }
  });
}

std::optional<GroundHit> RayCaster::first_hit(const dvec3& dir, double from_m) const {
  // An axis that the ray does not move along: a step so small that it stays where it is, never 0 times infinity.
  dvec3 inverse;
  for (int k = 0; k < 3; ++k) inverse[k] = 1.0 / (std::abs(dir[k]) < 1e-200 ? 1e-200 : dir[k]);
  double nearest = 1e300;
  GroundHit hit;
  for (const Tile& tile : tiles_) {
    const std::optional<double> tile_entry = tile.box.entry(inverse);
    if (!tile_entry || *tile_entry > nearest) continue;
    for (const Run& run : tile.runs) {
      const std::optional<double> entry = run.box.entry(inverse);
      if (!entry || *entry > nearest) continue;
      for (uint32_t k = run.first; k < run.first + run.count; k += 3) {
        const dvec3& a = tile.positions[topologies_.indices[k]];
        const dvec3& b = tile.positions[topologies_.indices[k + 1]];
        const dvec3& c = tile.positions[topologies_.indices[k + 2]];
        const std::optional<double> t = ray_triangle(a, b, c, dir);
        if (!t || *t < from_m || *t >= nearest) continue;
        nearest = *t;
        hit.normal = glm::normalize(glm::cross(b - a, c - a));
        hit.tile = tile.id;
      }
    }
  }
  if (nearest == 1e300) return std::nullopt;
  hit.distance_m = nearest;
  hit.point_ecef_m = origin_ + nearest * dir;
  return hit;
}

size_t RayCaster::triangles() const {
  size_t count = 0;
  for (const Tile& tile : tiles_)
    for (const Run& run : tile.runs) count += run.count / 3;
  return count;
}

}  // namespace nepho
