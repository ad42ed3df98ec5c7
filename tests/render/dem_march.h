#pragma once
#include <cmath>
#include <optional>
#include <vector>

#include "geo/geodetic.h"
#include "geo/geoid.h"
#include "io/raster.h"

namespace nepho {

/// An elevation raster whole in memory, read at its pixel centres bilinearly, above EGM96: what a ray should hit.
/// Shares no code with the terrain module.
class DemMarch {
 public:
  explicit DemMarch(const Raster& raster) : info_(raster.info()), values_(size_t{info_.width} * info_.height) {
    for (uint32_t by = 0; by * Raster::kBlockSize < info_.height; ++by)
      for (uint32_t bx = 0; bx * Raster::kBlockSize < info_.width; ++bx) {
        const Result<RasterBlock> block = raster.read_block(0, bx, by);
        for (uint32_t y = 0; y < block->height; ++y)
          for (uint32_t x = 0; x < block->width; ++x)
            values_[size_t{by * Raster::kBlockSize + y} * info_.width + bx * Raster::kBlockSize + x] =
                static_cast<double>(block->values[size_t{y} * block->width + x]);
      }
  }
  /// Above the ellipsoid, m; empty outside the outermost pixel centres.
  std::optional<double> height_m(const Geodetic& at) const {
    const LonLatBounds& b = info_.bounds;
    const double x = (at.lon_deg() - b.west_deg) / (b.east_deg - b.west_deg) * info_.width - 0.5;
    const double y = (b.north_deg - at.lat_deg()) / (b.north_deg - b.south_deg) * info_.height - 0.5;
    if (x < 0 || y < 0 || x >= info_.width - 1 || y >= info_.height - 1) return std::nullopt;
    const auto column = static_cast<size_t>(x), row = static_cast<size_t>(y);
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const auto v = [&](size_t r, size_t c) { return values_[r * info_.width + c]; };
    const double msl = (1 - fy) * ((1 - fx) * v(row, column) + fx * v(row, column + 1)) +
                       fy * ((1 - fx) * v(row + 1, column) + fx * v(row + 1, column + 1));
    return msl + Geoid::egm96().undulation_m(at.lat_rad, at.lon_rad);
  }
  /// Distance to the first hit along a unit direction, m: steps of `step_m` from `start_m`, then bisection to 1 cm.
  std::optional<double> hit(const dvec3& origin, const dvec3& dir, double start_m, double end_m, double step_m) const {
    const auto above = [&](double t) {
      const Geodetic at = geodetic_from_ecef(origin + t * dir);
      const std::optional<double> ground = height_m(at);
      return !ground || at.height_m > *ground;
    };
    for (double t = start_m; t < end_m; t += step_m) {
      if (above(t)) continue;
      double lo = t - step_m, hi = t;
      while (hi - lo > 0.01) (above(0.5 * (lo + hi)) ? lo : hi) = 0.5 * (lo + hi);
      return hi;
    }
    return std::nullopt;
  }

 private:
  RasterInfo info_;
  std::vector<double> values_;
};

}  // namespace nepho
