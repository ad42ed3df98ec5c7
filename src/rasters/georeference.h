#pragma once
#include <optional>

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

/// A dataset warped to EPSG:4326, and its grid.
struct WarpedDataset {
  GDALDatasetUniquePtr dataset;
  PixelGrid grid;
};

/// Warps (bilinear, on demand as blocks are read) to EPSG:4326 at the source's own resolution: east of the antimeridian
/// longitudes go on past 180, and a raster around a pole becomes a global strip. Without data: NaN for `elevation`,
/// else an alpha band whose full value is `alpha_max`. `alpha_is_data`: an alpha band of the source is warped like the
/// others, and the new one comes after it. Throws Error(input) when the CRS cannot be brought to EPSG:4326.
WarpedDataset warp_to_lon_lat(GDALDataset& source, const std::string& path, bool elevation, double alpha_max,
                              const GdalMessages& messages, bool alpha_is_data = false);

}  // namespace nepho
