#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geo/lonlat_tiles.h"
#include "terrain/block_cache.h"

namespace nepho {

/// Bilinear taps of a row (or column) of sample places on one axis of a reduced raster. A tap depends on its place and
/// on the raster alone, never on the other places, so that the same place yields the same bits whoever asks.
struct RasterAxis {
  struct Tap {
    uint32_t a = 0, b = 0;  ///< indices into `pixels`
    double f = 0.0;         ///< weight of b
  };
  static constexpr int64_t kOutside = -1;
  std::vector<int64_t> pixels;  ///< the pixels needed, in order of use; kOutside where the raster ends
  std::vector<Tap> taps;        ///< one per place
  bool any_inside = false;
};

/// Longitudes (any; degrees) on the columns of `raster` at a reduction. Beyond the raster's edge the coverage fades to
/// nothing within one pixel.
RasterAxis columns_at(const BlockCache& raster, uint32_t reduction, std::span<const double> lon_deg);
/// Latitudes on the rows. A raster that reaches a pole is continued over it.
RasterAxis rows_at(const BlockCache& raster, uint32_t reduction, std::span<const double> lat_deg);

/// Whether a raster shares some place with a tile.
bool overlaps(const LonLatBounds& raster, const TileBounds& tile);

/// The pixels that two axes name, side by side.
struct RasterWindow {
  uint32_t columns = 0, rows = 0, bands = 1;
  std::vector<float> values;   ///< rows * columns * bands
  std::vector<uint8_t> valid;  ///< rows * columns
  bool all_valid = false, none_valid = true;
};

void gather(const BlockCache& raster, uint32_t reduction, const RasterAxis& x, const RasterAxis& y, RasterWindow& out);

}  // namespace nepho
