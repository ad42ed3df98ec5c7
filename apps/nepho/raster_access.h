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

/// The default Earth as `nepho_bake` left it in data_dir()/earth; what is not there is empty.
DefaultEarth find_baked_earth();

/// Access without GDAL: opens the baked default Earth; every other raster is an Error(input) of one line.
RasterAccess baked_rasters();

}  // namespace nepho
