#include "geo/lonlat_tiles.h"

#include <doctest/doctest.h>

#include <set>
#include <unordered_set>

using namespace nepho;

TEST_CASE("level 0 has a western and an eastern root") {
  CHECK(tile_at(0, 10, -0.001) == TileId{0, 0, 0});
  CHECK(tile_at(0, 10, 0.0) == TileId{0, 1, 0});
  const TileBounds east = tile_bounds({0, 1, 0});
  CHECK(east.west_deg == 0.0);
  CHECK(east.east_deg == 180.0);
  CHECK(east.south_deg == -90.0);
  CHECK(east.north_deg == 90.0);
  CHECK_FALSE(tile_parent({0, 1, 0}).has_value());
}

TEST_CASE("a tile's four children cover it exactly, north-west first") {
  for (const TileId& tile : {TileId{0, 1, 0}, TileId{3, 7, 2}, TileId{20, 1000000, 99}}) {
    const TileBounds b = tile_bounds(tile);
    const TileBounds nw = tile_bounds(tile_child(tile, 0)), se = tile_bounds(tile_child(tile, 3));
    CHECK(nw.west_deg == b.west_deg);
    CHECK(nw.north_deg == b.north_deg);
    CHECK(se.east_deg == b.east_deg);
    CHECK(se.south_deg == b.south_deg);
    CHECK(nw.east_deg == se.west_deg);
    CHECK(nw.south_deg == se.north_deg);
    for (uint32_t i = 0; i < 4; ++i) CHECK(tile_parent(tile_child(tile, i)) == tile);
    CHECK(tile_bounds(tile_child(tile, 1)).west_deg == nw.east_deg);
    CHECK(tile_bounds(tile_child(tile, 2)).north_deg == nw.south_deg);
  }
}

TEST_CASE("neighbours wrap in longitude and end at the poles") {
  CHECK(tile_neighbour({2, 0, 1}, -1, 0) == TileId{2, 7, 1});
  CHECK(tile_neighbour({2, 7, 1}, 1, 0) == TileId{2, 0, 1});
  CHECK(tile_neighbour({2, 3, 1}, 0, 1) == TileId{2, 3, 2});
  CHECK_FALSE(tile_neighbour({2, 3, 0}, 0, -1).has_value());
  CHECK_FALSE(tile_neighbour({2, 3, 3}, 1, 1).has_value());
  CHECK(tile_neighbour({0, 0, 0}, 1, 0) == TileId{0, 1, 0});
  CHECK(tile_neighbour({0, 0, 0}, -1, 0) == TileId{0, 1, 0});
}

TEST_CASE("a place is in the tile that owns its west and north edge, at every level") {
  for (uint32_t level = 0; level <= kMaxTileLevel; ++level) {
    CAPTURE(level);
    const TileId fuji = tile_at(level, 35.3606, 138.7274);
    const TileBounds b = tile_bounds(fuji);
    CHECK((b.west_deg <= 138.7274 && 138.7274 < b.east_deg));
    CHECK((b.south_deg < 35.3606 && 35.3606 <= b.north_deg));
    CHECK(tile_ancestor(fuji, 0) == TileId{0, 1, 0});
    CHECK(tile_at(level, b.north_deg, b.west_deg) == fuji);
    CHECK(tile_at(level, 90, 180).x == 0);
    CHECK(tile_at(level, 90, 180).y == 0);
    CHECK(tile_at(level, -90, 179.99999999).y == tile_rows(level) - 1);
    CHECK(tile_at(level, 0, 359.0) == tile_at(level, 0, -1.0));
  }
  CHECK(tile_at(5, 0, -180.0 - 1e-14).x < tile_columns(5));  // rounds to 360 degrees east of -180
}

TEST_CASE("keys are unique and order is by level, row, column") {
  std::set<uint64_t> keys;
  std::unordered_set<TileId> tiles;
  size_t count = 0;
  for (uint32_t level = 0; level <= 5; ++level)
    for (uint32_t y = 0; y < tile_rows(level); ++y)
      for (uint32_t x = 0; x < tile_columns(level); ++x, ++count) {
        keys.insert(TileId{level, x, y}.key());
        tiles.insert(TileId{level, x, y});
      }
  CHECK(keys.size() == count);
  CHECK(tiles.size() == count);
  CHECK(TileId{1, 3, 0} < TileId{1, 0, 1});
  CHECK(TileId{1, 3, 1} < TileId{2, 0, 0});
  const TileId last{kMaxTileLevel, tile_columns(kMaxTileLevel) - 1, tile_rows(kMaxTileLevel) - 1};
  CHECK(last.key() != TileId{kMaxTileLevel, last.x - 1, last.y}.key());
  CHECK(last.key() > TileId{kMaxTileLevel - 1, 0, 0}.key());
}
