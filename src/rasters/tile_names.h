#pragma once
#include <cstdint>
#include <string>

namespace nepho {

/// Pictures (or heights) in square tiles, one file each, in zooms of twice the detail each: XYZ, or TMS with rows
/// from the south. Web Mercator (EPSG:3857, zoom 0 is one tile), or longitude and latitude (EPSG:4326, two tiles).
struct TileSet {
  std::string name;  ///< of a tile, with {z}, {x} and {y} (from the north) or {-y} (from the south)
  bool geodetic = false;
  int min_zoom = 0, max_zoom = 0;  ///< without a gap between them
  int coarsest_zoom = 0;           ///< whose tiles stand in for missing ones
  int tile_px = 256;
  bool heights = false;  ///< tiles of one band that are heights as they are; otherwise pictures, which become RGBA
  bool bytes = true;     ///< pictures: 8 bits
  /// Tiles of max_zoom that may exist, rows from the north; the ends are exclusive.
  int64_t x0 = 0, x1 = 1, y0 = 0, y1 = 1;
};

/// Whether a name has {z}, {x} and {y} or {-y} ("{q}", Bing's quadkey, stands for all three).
bool is_tile_template(const std::string& path);

/// Name of one tile, `y` from the north.
std::string tile_name(const TileSet& tiles, int zoom, int64_t x, int64_t y);

/// Tiles of a zoom around the Earth, and from pole to pole (of Mercator: from edge to edge).
int64_t tiles_across(const TileSet& tiles, int zoom);
int64_t tiles_down(const TileSet& tiles, int zoom);

bool is_url(const std::string& name);
bool contains(const std::string& text, const char* part);

}  // namespace nepho
