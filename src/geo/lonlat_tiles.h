#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace nepho {

/// Deepest level of the tile tree: 7e-7 degrees (7 cm) a tile.
inline constexpr uint32_t kMaxTileLevel = 28;

/// A tile of the EPSG:4326 quadtree. Level 0 has two tiles: x = 0 the western hemisphere, x = 1 the eastern one. Level
/// L has 2^(L+1) columns from -180 eastwards and 2^L rows from the north pole downwards; a tile spans 180 / 2^L
/// degrees.
struct TileId {
  uint32_t level = 0;
  uint32_t x = 0;  ///< column, from -180 degrees eastwards
  uint32_t y = 0;  ///< row, from +90 degrees southwards
  /// By level, then row, then column.
  auto operator<=>(const TileId& o) const {
    if (auto c = level <=> o.level; c != 0) return c;
    if (auto c = y <=> o.y; c != 0) return c;
    return x <=> o.x;
  }
  bool operator==(const TileId&) const = default;
  /// One number per tile, for hashing and file names.
  uint64_t key() const { return (uint64_t{level} << 57) | (uint64_t{x} << 28) | uint64_t{y}; }
};

/// Edges of a tile, degrees on WGS84; exact in double.
struct TileBounds {
  double west_deg = 0.0, south_deg = 0.0, east_deg = 0.0, north_deg = 0.0;
};

constexpr uint32_t tile_columns(uint32_t level) { return 2u << level; }
constexpr uint32_t tile_rows(uint32_t level) { return 1u << level; }
constexpr double tile_size_deg(uint32_t level) { return 180.0 / static_cast<double>(uint64_t{1} << level); }

TileBounds tile_bounds(const TileId& tile);

/// The level below: 0 north-west, 1 north-east, 2 south-west, 3 south-east.
TileId tile_child(const TileId& tile, uint32_t index);
/// Empty for the two roots.
std::optional<TileId> tile_parent(const TileId& tile);
/// The ancestor at a level no deeper than the tile's own.
TileId tile_ancestor(const TileId& tile, uint32_t level);

/// The tile `dx` columns east and `dy` rows south at the same level. Wraps around in longitude; empty over the poles.
std::optional<TileId> tile_neighbour(const TileId& tile, int64_t dx, int64_t dy);

/// The tile that holds a place. A tile owns its west and north edges; the south pole belongs to the last row. Any
/// longitude; the latitude is clamped to -90..90.
TileId tile_at(uint32_t level, double lat_deg, double lon_deg);

}  // namespace nepho

template <>
struct std::hash<nepho::TileId> {
  size_t operator()(const nepho::TileId& tile) const noexcept {
    // SplitMix64's finaliser: neighbouring keys fall far apart.
    uint64_t z = tile.key() + 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<size_t>(z ^ (z >> 31));
  }
};
