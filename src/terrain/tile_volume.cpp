#include "terrain/tile_volume.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "terrain/tile_mesh.h"

namespace nepho {

double TileVolume::distance_m(const dvec3& point) const {
  const dvec3 d = point - centre;
  dvec3 beyond;
  for (int i = 0; i < 3; ++i) beyond[i] = std::max(0.0, std::abs(dot(d, axis[i])) - half[i]);
  return length(beyond);
}

TileVolume make_tile_volume(const TileId& tile, double min_m, double max_m, const Ellipsoid& ellipsoid) {
  constexpr size_t kSide = 9;
  const TileBounds b = tile_bounds(tile);
  const double size = tile_size_deg(tile.level);
  double lat[kSide], lon[kSide], low[kSide * kSide], high[kSide * kSide];
  for (size_t i = 0; i < kSide; ++i) {
    lat[i] = b.north_deg - size * static_cast<double>(i) / (kSide - 1);
    lon[i] = b.west_deg + size * static_cast<double>(i) / (kSide - 1);
  }
  // Between two samples the surface bulges out of their chord by at most the sagitta of half a cell's diagonal.
  const double half_cell = rad_from_deg(size / (kSide - 1)) * 0.5 * std::numbers::sqrt2;
  const double bulge = (ellipsoid.a_m + std::max(0.0, max_m)) * (1.0 - std::cos(std::min(half_cell, 1.5)));
  std::fill_n(low, kSide * kSide, min_m);
  std::fill_n(high, kSide * kSide, max_m);
  dvec3 points[2 * kSide * kSide];
  grid_positions(lat, lon, low, ellipsoid, points);
  grid_positions(lat, lon, high, ellipsoid, points + kSide * kSide);

  TileVolume v;
  const double phi = rad_from_deg(lat[kSide / 2]), lambda = rad_from_deg(lon[kSide / 2]);
  v.axis[0] = {-std::sin(lambda), std::cos(lambda), 0.0};
  v.axis[2] = {std::cos(phi) * std::cos(lambda), std::cos(phi) * std::sin(lambda), std::sin(phi)};
  v.axis[1] = cross(v.axis[2], v.axis[0]);
  dvec3 lowest(std::numeric_limits<double>::infinity()), highest(-std::numeric_limits<double>::infinity());
  for (const dvec3& p : points)
    for (int a = 0; a < 3; ++a) {
      const double d = dot(p, v.axis[a]);
      lowest[a] = std::min(lowest[a], d);
      highest[a] = std::max(highest[a], d);
    }
  v.half = (highest - lowest) * 0.5 + dvec3(bulge + 0.01);
  for (int a = 0; a < 3; ++a) v.centre += v.axis[a] * ((lowest[a] + highest[a]) * 0.5);
  return v;
}

bool outside_frustum(const TileVolume& volume, const TerrainView& view) {
  constexpr double kMargin = 1.02;
  const dvec3 c = volume.centre - view.camera_ecef_m;
  // A point at distance w along forward and x right is in the picture when |x| |right|^2 <= w |right|^2.
  const dvec3 ahead_x = view.forward * (dot(view.right, view.right) * kMargin);
  const dvec3 ahead_y = view.forward * (dot(view.up, view.up) * kMargin);
  for (const dvec3& n :
       {ahead_x + view.right, ahead_x - view.right, ahead_y + view.up, ahead_y - view.up, view.forward}) {
    double reach = 0.0;
    for (int a = 0; a < 3; ++a) reach += volume.half[a] * std::abs(dot(volume.axis[a], n));
    if (dot(c, n) + reach < 0.0) return true;
  }
  return false;
}

bool below_horizon(const TileVolume& volume, const TerrainView& view) {
  // In the space where the lowered ellipsoid is the unit sphere, what it hides from the camera is a cone cut off by a
  // plane, which is convex: it holds a box when it holds the box's corners.
  const double a = view.ellipsoid.a_m - view.deepest_land_m, b = view.ellipsoid.b_m - view.deepest_land_m;
  const dvec3 scale(1.0 / a, 1.0 / a, 1.0 / b);
  const dvec3 eye = view.camera_ecef_m * scale;
  const double horizon2 = dot(eye, eye) - 1.0;  // squared distance to the horizon
  if (horizon2 <= 0.0) return false;
  for (int corner = 0; corner < 8; ++corner) {
    dvec3 p = volume.centre;
    for (int i = 0; i < 3; ++i) p += volume.axis[i] * (corner & (1 << i) ? volume.half[i] : -volume.half[i]);
    const dvec3 v = p * scale - eye;
    const double towards = -dot(v, eye);
    if (!(towards > horizon2 && towards * towards > horizon2 * dot(v, v))) return false;
  }
  return true;
}

}  // namespace nepho
