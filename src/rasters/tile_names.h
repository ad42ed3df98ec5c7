#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "io/raster.h"
#include "rasters/gdal_support.h"

namespace nepho {

/// Pictures (or heights) in square tiles, one file each, in zooms of twice the detail each: XYZ, or TMS with rows
/// from the south. Web Mercator (EPSG:3857, zoom 0 is one tile), or longitude and latitude (EPSG:4326, two tiles).
struct TileSet {
  std::string name;  ///< of a tile, with {z}, {x} and {y} (from the north) or {-y} (from the south)
  bool geodetic = false;
  int min_zoom = 0, max_zoom = 0;
  int tile_px = 256;
  bool heights = false;  ///< tiles of one band that are heights as they are; otherwise pictures, which become RGBA
  bool bytes = true;     ///< pictures: 8 bits
  /// Tiles of max_zoom that may exist, rows from the north; the ends are exclusive.
  int64_t x0 = 0, x1 = 1, y0 = 0, y1 = 1;
};

/// Whether a name has {z}, {x} and {y} or {-y} ("{q}", Bing's quadkey, stands for all three).
bool is_tile_template(const std::string& path);

/// The template for a folder that holds tiles as zoom/column/row.png (of any format); with a tilemapresource.xml, which
/// gdal2tiles writes, rows from the south, unless it says xyz. None for other folders.
std::optional<std::string> tile_template_of_folder(const std::string& folder);

/// What there is behind a template: listed for files of this machine, asked for by a first tile otherwise.
/// Throws Error(input) when no tile is found.
TileSet find_tiles(const std::string& path, const std::string& tile_template, const RasterReading& how, bool elevation,
                   const GdalMessages& messages);

/// Name of one tile, `y` from the north.
std::string tile_name(const TileSet& tiles, int zoom, int64_t x, int64_t y);

/// A tile, opened; none where it is missing. `failed`: it may be there, but could not be fetched or decoded (GDAL's
/// error says why).
GDALDatasetUniquePtr open_tile_file(const std::string& name, bool& failed);

}  // namespace nepho
