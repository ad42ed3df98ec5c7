#pragma once
#include <optional>
#include <string>

#include "io/raster.h"
#include "rasters/gdal_support.h"
#include "rasters/tile_names.h"

namespace nepho {

/// The template for a folder that holds tiles as zoom/column/row.png (of any format); with a tilemapresource.xml, which
/// gdal2tiles writes, rows from the south, unless it says xyz. None for other folders.
std::optional<std::string> tile_template_of_folder(const std::string& folder);

/// What there is behind a template: listed for files of this machine, asked for by a first tile otherwise.
/// Throws Error(input) when no tile is found.
TileSet find_tiles(const std::string& path, const std::string& tile_template, const RasterReading& how, bool elevation,
                   const GdalMessages& messages);

}  // namespace nepho
