#include "rasters/tile_names.h"

namespace nepho {

namespace {

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
}

}  // namespace

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

bool is_url(const std::string& name) { return name.starts_with("http://") || name.starts_with("https://"); }

int64_t tiles_across(const TileSet& tiles, int zoom) { return int64_t{1} << (zoom + (tiles.geodetic ? 1 : 0)); }
int64_t tiles_down(const TileSet&, int zoom) { return int64_t{1} << zoom; }

bool is_tile_template(const std::string& path) {
  if (path.starts_with('<')) return false;  // a description in XML, which has templates of its own
  return contains(path, "{q}") ||
         (contains(path, "{z}") && contains(path, "{x}") && (contains(path, "{y}") || contains(path, "{-y}")));
}

std::string tile_name(const TileSet& tiles, int zoom, int64_t x, int64_t y) {
  std::string name = tiles.name;
  if (contains(name, "{q}")) {
    std::string key;
    for (int bit = zoom - 1; bit >= 0; --bit) key += static_cast<char>('0' + ((x >> bit) & 1) + 2 * ((y >> bit) & 1));
    replace_all(name, "{q}", key);
  }
  replace_all(name, "{z}", std::to_string(zoom));
  replace_all(name, "{x}", std::to_string(x));
  replace_all(name, "{y}", std::to_string(y));
  replace_all(name, "{-y}", std::to_string(tiles_down(tiles, zoom) - 1 - y));
  replace_all(name, "{s}", std::string(1, static_cast<char>('a' + (x + y) % 3)));
  return name;
}

}  // namespace nepho
