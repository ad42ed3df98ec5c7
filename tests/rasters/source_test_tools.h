#pragma once
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

namespace nepho::test {

inline std::shared_ptr<Raster> elevation(const std::string& path, const RasterReading& how = {}) {
  return make_gdal_opener()->open_elevation(path, how);
}
inline std::shared_ptr<Raster> imagery(const std::string& path, const RasterReading& how = {}) {
  return make_gdal_opener()->open_imagery(path, how);
}

/// One degree square with its south-west corner at (lon, lat): one height.
inline RasterRecipe square(double lon, double lat, double height_m, int side = 20) {
  return {.width = side,
          .height = side,
          .type = GDT_Int16,
          .geotransform = {lon, 1.0 / side, 0, lat + 1, 0, -1.0 / side},
          .crs = "EPSG:4326",
          .value = [=](int, int, int) { return height_m; }};
}

}  // namespace nepho::test
