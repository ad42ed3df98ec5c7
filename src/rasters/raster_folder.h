#pragma once
#include <string>
#include <vector>

#include "rasters/gdal_support.h"

namespace nepho {

/// A folder of rasters put together.
struct RasterMosaic {
  std::string name;                ///< a VRT in memory, to be opened with GDAL
  std::vector<std::string> files;  ///< what it is made of, in order: later over earlier
};

/// All rasters in a folder and its subfolders, by name, later over earlier, as one dataset: of the CRS that they share,
/// or of EPSG:4326. What is no raster is skipped with one warning, and so are files whose bands differ from those of
/// most. Throws Error(input) when there is no raster.
RasterMosaic mosaic_of_folder(const std::string& folder, bool elevation, const GdalMessages& messages);

}  // namespace nepho
