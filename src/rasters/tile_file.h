#pragma once
#include <string>

#include "rasters/gdal_support.h"

namespace nepho {

/// A tile, opened; none where it is missing. `failed`: it may be there, but could not be fetched or decoded (GDAL's
/// error says why).
GDALDatasetUniquePtr open_tile_file(const std::string& name, bool& failed);

}  // namespace nepho
