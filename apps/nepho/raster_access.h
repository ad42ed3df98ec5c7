#pragma once
#include <functional>
#include <memory>
#include <string>

#include "io/raster.h"
#include "rasters/default_earth.h"

namespace nepho {

/// How a program gets at rasters: what tells `nepho`, which has GDAL, from `nepho_portable`, which has not.
struct RasterAccess {
  std::shared_ptr<const RasterOpener> opener;
  std::function<DefaultEarth()> find_default_earth;
  std::string gdal_version;  ///< for `nepho info`; empty: this build has no GDAL
  bool has_gdal() const { return !gdal_version.empty(); }
};

/// Access that opens nothing and knows of no default Earth: every raster is an Error(input) of one line.
RasterAccess no_rasters();

}  // namespace nepho
