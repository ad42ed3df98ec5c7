#include "terrain/imagery_grid.h"

#include <algorithm>
#include <cmath>

#include "terrain/terrain_shared.h"

namespace nepho {

namespace {

constexpr double kBorder = shared::kTerrainBorderTexels;
/// The first texel's number is a multiple of this, so that the mips of neighbours are the same texels, too.
constexpr double kAligned = 1u << (shared::kTerrainImageryMips - 1);
constexpr double kMostAcross = shared::kTerrainImageryTexels - 2.0 * kBorder - kAligned;
/// A place where no picture is has texels for its coasts alone.
constexpr double kNoPicture = 1u << 20;

struct Axis {
  double first = 0.0, step = 0.0;
  bool coarse = false, parts = false;
};

/// Texels of one axis: pixels begin at `origin` and grow towards positive numbers, as do the texels.
Axis axis_of(double from, double size, double origin, double pixel) {
  Axis out;
  const double least = size / kMostAcross * (1.0 - 1e-9);
  if (pixel >= 2.0 * least) {
    const double n = std::floor(pixel / least);
    out.step = pixel / n;
    origin += 0.5 * (pixel - out.step);
    out.parts = true;
  } else {
    out.step = pixel * std::exp2(std::max(0.0, std::ceil(std::log2(least / pixel))));
    out.coarse = out.step > 1.5 * pixel;
  }
  const double index = std::floor(((from - origin) / out.step - kBorder) / kAligned) * kAligned;
  out.first = origin + index * out.step;
  return out;
}

}  // namespace

double ImageryGrid::texel_deg() const { return std::max(lon_step_deg, lat_step_deg); }

std::vector<double> ImageryGrid::lats_deg() const {
  std::vector<double> out(shared::kTerrainImageryTexels);
  for (size_t j = 0; j < out.size(); ++j)
    out[j] = std::clamp(north_deg - (static_cast<double>(j) + 0.5) * lat_step_deg, -90.0, 90.0);
  return out;
}

std::vector<double> ImageryGrid::lons_deg() const {
  std::vector<double> out(shared::kTerrainImageryTexels);
  for (size_t i = 0; i < out.size(); ++i) out[i] = west_deg + (static_cast<double>(i) + 0.5) * lon_step_deg;
  return out;
}

ImageryGrid imagery_grid(const TileId& tile, const std::optional<PixelLattice>& finest) {
  const TileBounds b = tile_bounds(tile);
  const double size = tile_size_deg(tile.level);
  PixelLattice p;
  if (finest)
    p = *finest;
  else
    p = {b.west_deg, b.north_deg, kNoPicture * size, kNoPicture * size, 1.0, 0.5 * (b.west_deg + b.east_deg)};
  // Rasters across the antimeridian go on past 180. All tiles on a raster count its pixels from the same one: a turn
  // around the Earth need not be a whole number of kAligned texels.
  const double middle = 0.5 * (b.west_deg + b.east_deg);
  const double west = p.west_deg + 360.0 * std::round((middle - p.middle_deg) / 360.0);
  const Axis x = axis_of(b.west_deg, size, west, p.lon_deg);
  const Axis y = axis_of(-b.north_deg, size, -p.north_deg, p.lat_deg);
  ImageryGrid out;
  out.west_deg = x.first;
  out.north_deg = -y.first;
  out.lon_step_deg = x.step;
  out.lat_step_deg = y.step;
  out.coarse_deg = std::max(x.coarse ? x.step : 0.0, y.coarse ? y.step : 0.0);
  out.source_deg = std::max(p.lon_deg, p.lat_deg) * p.oversampling;
  // The larger side: where the other is smaller, as with Mercator warped to its finest rows, pixels are parts of
  // pixels.
  out.detail_log2 = std::max(0.0, std::log2(out.source_deg / std::sqrt(x.step * y.step)));
  out.parts = x.parts && y.parts;
  return out;
}

}  // namespace nepho
