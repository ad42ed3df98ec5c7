#pragma once
#include <string>

#include "rasters/gdal_support.h"

namespace nepho {

/// Heights in the colours of a picture.
enum class HeightCode {
  none,
  terrarium,  ///< 256 R + G + B / 256 - 32768, m (Mapzen)
  mapbox,     ///< 0.1 (65536 R + 256 G + B) - 10000, m (Mapbox Terrain-RGB)
};

/// What `encoding` (auto, none, terrarium, mapbox) means for a dataset: auto looks at the name and at the numbers of a
/// picture of 8 bits.
HeightCode height_code(GDALDataset& dataset, const std::string& encoding, const std::string& path);

/// A picture whose colours are heights as one band of metres, NaN where it is transparent; overviews too. `picture`
/// must outlive it.
GDALDatasetUniquePtr decode_heights(GDALDataset& picture, HeightCode code);

}  // namespace nepho
