#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geo/geodetic.h"
#include "terrain/tile_mesh.h"
#include "terrain/tile_select.h"

namespace nepho {

/// Distance, in lengths of `dir`, at which a ray from the origin crosses the triangle, from whichever side; empty where
/// it misses it or lies in its plane. Edges belong to both triangles that share them (their vertices to the bit), so
/// that no ray slips through between two.
std::optional<double> ray_triangle(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& dir);

/// Where a ray meets the ground.
struct GroundHit {
  double distance_m = 0.0;
  dvec3 point_ecef_m{0.0};
  dvec3 normal{0.0};  ///< of the triangle, unit, towards the sky, ECEF axes
  TileId tile;
};

/// Rays from one place against the very triangles that a frame draws: the selected tiles with their levels, borders and
/// visible quarters. What the rasteriser does in floats is done here in double; the two differ by its rounding
/// (docs/terrain.md, 'Queries'). Thread-safe once made.
class RayCaster {
 public:
  /// The 65 x 65 vertices of a tile as they are drawn, row by row, ECEF, m.
  using Positions = std::function<std::vector<dvec3>(const SelectedTile&)>;
  /// Asks for the positions of all tiles, from several threads at once.
  RayCaster(const dvec3& origin_ecef_m, std::span<const SelectedTile> tiles, const Positions& positions);

  /// The nearest hit beyond `from_m` along the unit direction `dir`.
  std::optional<GroundHit> first_hit(const dvec3& dir, double from_m = 0.0) const;
  size_t triangles() const;

 private:
  struct Box {
    dvec3 low{1e300}, high{-1e300};
    void hold(const dvec3& p);
    /// Distance at which the ray from the origin enters, `inverse` 1 / dir; empty: it misses.
    std::optional<double> entry(const dvec3& inverse) const;
  };
  struct Run {  ///< triangles that lie side by side
    uint32_t first = 0, count = 0;
    Box box;
  };
  struct Tile {
    TileId id;
    std::vector<dvec3> positions;  ///< from the origin, m
    std::vector<Run> runs;
    Box box;
  };
  dvec3 origin_;
  TileTopologies topologies_;
  std::vector<Tile> tiles_;
};

}  // namespace nepho
