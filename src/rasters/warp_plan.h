#pragma once
#include <string>
#include <vector>

#include "rasters/georeference.h"

namespace nepho {

/// How a dataset is warped to EPSG:4326: decided once, done as often as it is opened.
struct WarpPlan {
  /// The warp at half the resolution `level` times, from an overview of the source (-1: the source itself).
  struct Level {
    uint32_t level = 0;
    int overview = -1;
  };
  std::vector<std::string> args;  ///< of gdalwarp, for all levels
  int width = 0, height = 0;      ///< px of level 0; they halve exactly to every level
  PixelGrid grid;                 ///< of level 0
  uint32_t finer_levels = 0;      ///< level 0 has 2^this pixels for one of the source, along each axis
  std::vector<Level> levels;      ///< level 0 first
};

/// Warps (bilinear, on demand as blocks are read) to EPSG:4326 at the source's own resolution, or 2^`finer_levels`
/// times as fine: east of the antimeridian longitudes go on past 180, and a raster around a pole becomes a global
/// strip. Without data: NaN for `elevation`, else an alpha band whose full value is `alpha_max`. `alpha_is_data`: an
/// alpha band of the source is warped like the others, and the new one comes after it. Throws Error(input) when the CRS
/// cannot be brought to EPSG:4326.
WarpPlan plan_warp(GDALDataset& source, const std::string& path, bool elevation, double alpha_max,
                   const GdalMessages& messages, bool alpha_is_data = false, uint32_t finer_levels = 0);

/// `source` must outlive the result.
GDALDatasetUniquePtr warp(GDALDataset& source, const WarpPlan& plan, const WarpPlan::Level& level,
                          const std::string& path, const GdalMessages& messages);

}  // namespace nepho
