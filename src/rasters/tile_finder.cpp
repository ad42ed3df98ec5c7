#include "rasters/tile_finder.h"

#include <cpl_string.h>
#include <cpl_vsi.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <regex>
#include <vector>

#include "base/error.h"
#include "rasters/tile_file.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

constexpr int kUrlZoomImagery = 19, kUrlZoomElevation = 15;

bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 10 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

std::vector<std::string> entries_of(const std::string& folder) {
  std::vector<std::string> names;
  char** const all = VSIReadDir(folder.c_str());
  for (char** name = all; name && *name; ++name)
    if (std::string(*name) != "." && std::string(*name) != "..") names.emplace_back(*name);
  CSLDestroy(all);
  std::sort(names.begin(), names.end());
  return names;
}

struct Found {
  int zoom = 0;
  int64_t x = 0, y = 0;  // as in the name
};

/// Looks for the files behind a template, folder by folder.
class TileSearch {
 public:
  explicit TileSearch(const std::string& tile_template) {
    const size_t brace = tile_template.find('{');
    const size_t slash = tile_template.rfind('/', brace);
    root_ = slash == std::string::npos ? "." : tile_template.substr(0, std::max<size_t>(slash, 1));
    std::string rest = slash == std::string::npos ? tile_template : tile_template.substr(slash + 1);
    for (size_t at; (at = rest.find('/')) != std::string::npos; rest.erase(0, at + 1))
      parts_.push_back(part(rest.substr(0, at)));
    parts_.push_back(part(rest));
  }
  /// The zooms there are, as far as folders' names say; none when files' names have to be looked at.
  std::vector<int> zooms() const {
    std::vector<int> found;
    if (parts_.size() > 1 && parts_[0].keys == "z")
      for (const std::string& name : entries_of(root_)) {
        std::smatch match;
        if (std::regex_match(name, match, parts_[0].pattern)) found.push_back(std::atoi(match[1].str().c_str()));
      }
    return found;
  }
  /// Calls `visit` for the tiles of a zoom (or of all, -1) until it returns false. Looks into so many folders at most;
  /// false when there are more.
  bool each(int zoom, const std::function<bool(const Found&)>& visit) {
    folders_left_ = kMostFolders;
    zoom_ = zoom;
    stopped_ = false;
    walk(root_, 0, {}, visit);
    return stopped_ || folders_left_ > 0;
  }

 private:
  static constexpr int kMostFolders = 4096;
  struct Part {
    std::regex pattern;
    std::string keys;  // of its groups: z, x, y
  };
  static Part part(const std::string& text) {
    std::string pattern, keys;
    for (size_t i = 0; i < text.size();) {
      const size_t end = text[i] == '{' ? text.find('}', i) : std::string::npos;
      if (end != std::string::npos) {
        const std::string key = text.substr(i + 1, end - i - 1);
        if (key == "z" || key == "x" || key == "y" || key == "-y") {
          pattern += "([0-9]+)";
          keys += key.back();
          i = end + 1;
          continue;
        }
      }
      if (!std::isalnum(static_cast<unsigned char>(text[i]))) pattern += '\\';
      pattern += text[i++];
    }
    return {std::regex(pattern), keys};
  }
  void walk(const std::string& folder, size_t depth, Found at, const std::function<bool(const Found&)>& visit) {
    if (--folders_left_ <= 0) return;
    for (const std::string& name : entries_of(folder)) {
      std::smatch match;
      if (!std::regex_match(name, match, parts_[depth].pattern)) continue;
      Found here = at;
      for (size_t k = 0; k < parts_[depth].keys.size(); ++k) {
        const int64_t value = std::atoll(match[k + 1].str().c_str());
        if (parts_[depth].keys[k] == 'z') here.zoom = static_cast<int>(value);
        if (parts_[depth].keys[k] == 'x') here.x = value;
        if (parts_[depth].keys[k] == 'y') here.y = value;
      }
      if (zoom_ >= 0 && contains(parts_[depth].keys, "z") && here.zoom != zoom_) continue;
      if (depth + 1 < parts_.size())
        walk(folder + "/" + name, depth + 1, here, visit);
      else if (!visit(here))
        stopped_ = true;
      if (stopped_ || folders_left_ <= 0) return;
    }
  }
  std::string root_;
  std::vector<Part> parts_;
  int folders_left_ = 0, zoom_ = -1;
  bool stopped_ = false;
};

/// Size and kind of the tiles from one of them.
void learn_from(TileSet& tiles, GDALDataset& tile, bool elevation) {
  tiles.tile_px = tile.GetRasterXSize();
  GDALRasterBand& band = *tile.GetRasterBand(1);
  tiles.bytes = band.GetRasterDataType() == GDT_Byte;
  tiles.heights = elevation && tile.GetRasterCount() <= 2 && band.GetColorTable() == nullptr;
}

void find_local_tiles(TileSet& tiles, const std::string& path, const RasterReading& how) {
  TileSearch search(tiles.name);
  std::vector<int> zooms = search.zooms();
  if (zooms.empty())
    search.each(-1, [&](const Found& tile) {
      if (std::find(zooms.begin(), zooms.end(), tile.zoom) == zooms.end()) zooms.push_back(tile.zoom);
      return true;
    });
  std::erase_if(zooms, [&](int z) { return z > 22 || z < how.min_zoom || (how.max_zoom >= 0 && z > how.max_zoom); });
  std::sort(zooms.begin(), zooms.end(), std::greater<>());
  const bool from_south = contains(tiles.name, "{-y}");
  for (const int zoom : zooms) {  // the finest that has any tile
    tiles.max_zoom = zoom;
    int64_t west = tiles_across(tiles, zoom), east = 0, north = tiles_down(tiles, zoom), south = 0;
    const bool all = search.each(zoom, [&](const Found& tile) {
      const int64_t y = from_south ? tiles_down(tiles, zoom) - 1 - tile.y : tile.y;
      if (tile.x >= tiles_across(tiles, zoom) || y < 0 || y >= tiles_down(tiles, zoom)) return true;
      west = std::min(west, tile.x);
      east = std::max(east, tile.x + 1);
      north = std::min(north, y);
      south = std::max(south, y + 1);
      return true;
    });
    if (west >= east) continue;
    tiles.x0 = all ? west : 0;
    tiles.x1 = all ? east : tiles_across(tiles, zoom);
    tiles.y0 = all ? north : 0;
    tiles.y1 = all ? south : tiles_down(tiles, zoom);
    tiles.coarsest_zoom = zooms.back();
    tiles.min_zoom = zoom;
    while (std::find(zooms.begin(), zooms.end(), tiles.min_zoom - 1) != zooms.end()) --tiles.min_zoom;
    return;
  }
  throw fail(ErrorKind::input, "{}: no tiles found{}", path,
             how.min_zoom > 0 || how.max_zoom >= 0 ? " between min_zoom and max_zoom" : "");
}

/// A tile of files of this machine to learn from.
GDALDatasetUniquePtr first_local_tile(const TileSet& tiles, const std::string& path, const GdalMessages& messages) {
  GDALDatasetUniquePtr tile;
  std::string name;
  bool failed = false;
  const bool from_south = contains(tiles.name, "{-y}");
  TileSearch(tiles.name).each(tiles.max_zoom, [&](const Found& at) {
    name = tile_name(tiles, tiles.max_zoom, at.x, from_south ? tiles_down(tiles, tiles.max_zoom) - 1 - at.y : at.y);
    tile = open_tile_file(name, failed);
    return false;
  });
  if (!tile)
    throw fail(ErrorKind::input, "{}: its tile {} is not a picture that GDAL can open{}", path, name,
               messages.in_brackets());
  return tile;
}

/// A tile of a server: the first that is there, from the coarsest zoom.
GDALDatasetUniquePtr first_remote_tile(const TileSet& tiles, const std::string& path, const GdalMessages& messages) {
  constexpr int kMostTries = 24;
  int tries = 0;
  for (int zoom = tiles.min_zoom; zoom <= tiles.max_zoom; ++zoom)
    for (int64_t y = 0; y < tiles_down(tiles, zoom); ++y)
      for (int64_t x = 0; x < tiles_across(tiles, zoom); ++x) {
        bool failed = false;
        GDALDatasetUniquePtr tile = open_tile_file(tile_name(tiles, zoom, x, y), failed);
        if (tile) return tile;
        if (failed)
          throw fail(ErrorKind::input, "{}: its tile {} cannot be had{}", path, tile_name(tiles, zoom, x, y),
                     messages.in_brackets());
        if (++tries == kMostTries) return nullptr;
      }
  return nullptr;
}

}  // namespace

std::optional<std::string> tile_template_of_folder(const std::string& folder) {
  for (const std::string& zoom : entries_of(folder)) {
    if (!is_number(zoom)) continue;
    for (const std::string& column : entries_of(folder + "/" + zoom)) {
      if (!is_number(column)) continue;
      for (const std::string& row : entries_of(folder + "/" + zoom + "/" + column)) {
        const size_t dot = row.find('.');
        if (dot == std::string::npos || !is_number(row.substr(0, dot)) || row.ends_with(".xml")) continue;
        std::string described;
        if (VSILFILE* file = VSIFOpenL((folder + "/tilemapresource.xml").c_str(), "rb")) {
          described.resize(4096);
          described.resize(VSIFReadL(described.data(), 1, described.size(), file));
          VSIFCloseL(file);
        }
        const bool from_south = !described.empty() && !contains(described, "xyz");
        return folder + "/{z}/{x}/" + (from_south ? "{-y}" : "{y}") + row.substr(dot);
      }
    }
  }
  return std::nullopt;
}

TileSet find_tiles(const std::string& path, const std::string& tile_template, const RasterReading& how, bool elevation,
                   const GdalMessages& messages) {
  TileSet tiles;
  tiles.name = tile_template;
  // A folder made by gdal2tiles says its grid.
  const size_t brace = tile_template.find('{');
  if (VSILFILE* file = VSIFOpenL((tile_template.substr(0, brace) + "tilemapresource.xml").c_str(), "rb");
      file && !is_url(tile_template)) {
    std::string text(4096, '\0');
    text.resize(VSIFReadL(text.data(), 1, text.size(), file));
    tiles.geodetic = contains(text, "EPSG:4326") || contains(text, "geodetic");
    VSIFCloseL(file);
  }
  GDALDatasetUniquePtr tile;
  if (!is_url(tile_template) && !tile_template.starts_with("/vsi") && !contains(tile_template, "{q}")) {
    find_local_tiles(tiles, path, how);
    tile = first_local_tile(tiles, path, messages);
  } else {
    tiles.min_zoom = tiles.coarsest_zoom = how.min_zoom;
    tiles.max_zoom = std::max(how.min_zoom, how.max_zoom >= 0 ? how.max_zoom
                                            : elevation       ? kUrlZoomElevation
                                                              : kUrlZoomImagery);
    tiles.x1 = tiles_across(tiles, tiles.max_zoom);
    tiles.y1 = tiles_down(tiles, tiles.max_zoom);
    tile = first_remote_tile(tiles, path, messages);
    // A service without a world map: nothing tells where its tiles are, so the usual ones are expected.
    if (!tile) return tiles;
  }
  if (tile->GetRasterXSize() != tile->GetRasterYSize() || tile->GetRasterXSize() < 16 || tile->GetRasterXSize() > 4096)
    throw fail(ErrorKind::input, "{}: its tiles are {} x {} pixels; they are squares of 256 or 512", path,
               tile->GetRasterXSize(), tile->GetRasterYSize());
  learn_from(tiles, *tile, elevation);
  return tiles;
}

}  // namespace nepho
