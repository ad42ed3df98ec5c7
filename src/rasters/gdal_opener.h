#pragma once
#include <memory>

#include "io/raster.h"

namespace nepho {

/// Opens whatever GDAL reads, and puts it on the EPSG:4326 grid by the rules of docs/data.md. Thread-safe, and so are
/// its rasters. GDAL is set up at the first call; its own messages become part of ours.
std::unique_ptr<RasterOpener> make_gdal_opener();

}  // namespace nepho
