#pragma once
#include "geo/geodetic.h"
#include "geo/lonlat_tiles.h"

namespace nepho {

/// A box that holds all of a tile's surface: centre, three orthonormal axes (east, north, up at the tile's centre) and
/// half sizes, ECEF, m.
struct TileVolume {
  dvec3 centre{0.0};
  dvec3 axis[3] = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
  dvec3 half{0.0};
  double distance_m(const dvec3& point) const;  ///< 0 inside
};

/// The box around the tile between two heights above the ellipsoid.
TileVolume make_tile_volume(const TileId& tile, double min_m, double max_m, const Ellipsoid& ellipsoid);

/// Where tiles are looked at from. `right` and `up` carry the tangents of half the field of view, `forward` is unit.
struct TerrainView {
  dvec3 camera_ecef_m{0.0};
  dvec3 forward{1, 0, 0}, right{0, 1, 0}, up{0, 0, 1};
  double pixel_angle_rad = 1e-3;
  double screen_error_px = 1.0;
  Ellipsoid ellipsoid;
  double deepest_land_m = 500.0;  ///< the ellipsoid lowered by this hides what is behind it
};

/// True when no part of the box is in the picture (with a margin of 2 % of its size). Never true for a visible box.
bool outside_frustum(const TileVolume& volume, const TerrainView& view);
/// True when the lowered ellipsoid hides all of the box. Never true for a visible box.
bool below_horizon(const TileVolume& volume, const TerrainView& view);

}  // namespace nepho
