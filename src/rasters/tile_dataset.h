#pragma once
#include "rasters/tile_names.h"

namespace nepho {

/// Tiles as one dataset of GDAL, with an overview for each coarser zoom: RGBA, or one band of heights (no data: NaN).
/// A tile that is missing has no data (alpha 0); one that cannot be fetched fails the read.
GDALDatasetUniquePtr make_tile_dataset(const TileSet& tiles);

}  // namespace nepho
