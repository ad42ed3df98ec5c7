#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/raster.h"
#include "rasters/gdal_support.h"

namespace nepho {

/// Which pixels of a dataset are delivered, how, and where they lie.
struct PixelGrid {
  LonLatBounds bounds;
  bool wraps = false;
  int x_off = 0, y_off = 0;     ///< first dataset column and row used (columns and rows off the Earth are left out)
  int width = 0, height = 0;    ///< dataset px used
  bool flip_x = false;          ///< columns run east to west
  bool flip_y = false;          ///< rows run south to north
  bool assumed_global = false;  ///< no georeference, exactly 2:1: taken as -180..180, -90..90
};

/// The grid of a dataset whose pixels are already rows of latitude and columns of longitude on WGS84, so that they can
/// be delivered as they are; none when it has to be warped. Throws Error(input) when nothing says where it lies.
std::optional<PixelGrid> native_grid(GDALDataset& dataset, const std::string& path, const GdalMessages& messages);

/// What heights are above, from the CRS; a raster without a vertical CRS is above EGM96. Warns when it is another
/// geoid.
VerticalDatum vertical_datum(GDALDataset& dataset, const std::string& path);

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
