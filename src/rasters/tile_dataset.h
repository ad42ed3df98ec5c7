#pragma once
#include "rasters/gdal_support.h"
#include "rasters/tile_names.h"

namespace nepho {

/// Tiles as one dataset of GDAL, with an overview for each coarser zoom: RGBA, or one band of heights (no data: NaN).
/// Where a tile is missing the nearest coarser zoom that has one is shown, its pixels repeated; without any there is no
/// data (alpha 0). A tile that cannot be fetched fails the read.
GDALDatasetUniquePtr make_tile_dataset(const TileSet& tiles);

}  // namespace nepho
