#pragma once
#include <array>
#include <optional>
#include <string>

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

/// lon = g[0] + g[1] column + g[2] row, lat = g[3] + g[4] column + g[5] row
using GeoTransform = std::array<double, 6>;

/// Degrees of an axis-aligned geotransform as a grid: west in reach of -180..180, global rasters exactly 360 wide, rows
/// whose centre is beyond a pole left out.
PixelGrid grid_of(const GeoTransform& g, int width, int height);

/// The grid of a dataset whose pixels are already rows of latitude and columns of longitude on WGS84, so that they can
/// be delivered as they are; none when it has to be warped. Throws Error(input) when nothing says where it lies.
std::optional<PixelGrid> native_grid(GDALDataset& dataset, const std::string& path, const GdalMessages& messages);

/// What heights are above, from the CRS; a raster without a vertical CRS is above EGM96. Warns when it is another
/// geoid.
VerticalDatum vertical_datum(GDALDataset& dataset, const std::string& path);

}  // namespace nepho
