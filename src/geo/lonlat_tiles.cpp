#include "geo/lonlat_tiles.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace nepho {

TileBounds tile_bounds(const TileId& tile) {
  const double size = tile_size_deg(tile.level);
  const double x = static_cast<double>(tile.x), y = static_cast<double>(tile.y);
  return {-180.0 + size * x, 90.0 - size * (y + 1.0), -180.0 + size * (x + 1.0), 90.0 - size * y};
}

TileId tile_child(const TileId& tile, uint32_t index) {
  NEPHO_ASSERT_OP(index, <, 4u);
  NEPHO_ASSERT_OP(tile.level, <, kMaxTileLevel);
  return {tile.level + 1, 2 * tile.x + (index & 1u), 2 * tile.y + (index >> 1)};
}

std::optional<TileId> tile_parent(const TileId& tile) {
  if (tile.level == 0) return std::nullopt;
  return TileId{tile.level - 1, tile.x / 2, tile.y / 2};
}

TileId tile_ancestor(const TileId& tile, uint32_t level) {
  NEPHO_ASSERT_OP(level, <=, tile.level);
  const uint32_t up = tile.level - level;
  return {level, tile.x >> up, tile.y >> up};
}

std::optional<TileId> tile_neighbour(const TileId& tile, int64_t dx, int64_t dy) {
  const int64_t columns = tile_columns(tile.level), rows = tile_rows(tile.level);
  const int64_t y = static_cast<int64_t>(tile.y) + dy;
  if (y < 0 || y >= rows) return std::nullopt;
  const int64_t x = ((static_cast<int64_t>(tile.x) + dx) % columns + columns) % columns;
  return TileId{tile.level, static_cast<uint32_t>(x), static_cast<uint32_t>(y)};
}

TileId tile_at(uint32_t level, double lat_deg, double lon_deg) {
  NEPHO_ASSERT_OP(level, <=, kMaxTileLevel);
  NEPHO_ASSERT(std::isfinite(lat_deg) && std::isfinite(lon_deg));
  const double size = tile_size_deg(level);
  const double east = lon_deg + 180.0 - 360.0 * std::floor((lon_deg + 180.0) / 360.0);
  const double south = 90.0 - std::clamp(lat_deg, -90.0, 90.0);
  // The subtraction may round up to 360 itself.
  const uint32_t x = static_cast<uint32_t>(east / size) % tile_columns(level);
  const uint32_t y = std::min(static_cast<uint32_t>(south / size), tile_rows(level) - 1);
  return {level, x, y};
}

}  // namespace nepho
