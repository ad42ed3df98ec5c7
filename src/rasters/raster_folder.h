#pragma once
#include <string>
#include <vector>

#include "rasters/gdal_support.h"

namespace nepho {

/// Rasters of a folder that make one grid.
struct RasterMosaic {
  std::string name;                ///< to be opened with GDAL: the one file, or a VRT in memory
  std::vector<std::string> files;  ///< what it is made of, in order: later over earlier
};

/// All rasters in a folder and its subfolders, as few mosaics as reasonable, bottom first: rasters of one CRS, like
/// bands and like resolution that touch each other are one (raster_clusters.h); later names lie over earlier ones. What
/// is no raster, has no place or other bands than most is skipped with one warning. Throws Error(input) when there is
/// no raster.
std::vector<RasterMosaic> mosaics_of_folder(const std::string& folder, bool elevation, const GdalMessages& messages);

}  // namespace nepho
