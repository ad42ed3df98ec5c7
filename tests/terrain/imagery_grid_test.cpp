#include "terrain/imagery_grid.h"

#include <doctest/doctest.h>

#include <cmath>

#include "terrain/terrain_shared.h"

using namespace nepho;

namespace {

constexpr double kTexels = shared::kTerrainImageryTexels;
/// A picture across the antimeridian whose pixels have nothing to do with the tiles', wider than high.
const PixelLattice kPicture{.west_deg = 170.03, .north_deg = 50.01, .lon_deg = 0.0123, .lat_deg = 0.0101, .middle_deg = 180.0};

/// Distance of a place from the nearest pixel's centre, in pixels.
double from_centre(double place, double first_edge, double pixel) {
  const double at = (place - first_edge) / pixel - 0.5;
  return std::abs(at - std::round(at));
}

void check_holds_tile(const ImageryGrid& g, const TileId& tile) {
  const TileBounds b = tile_bounds(tile);
  constexpr double kBorder = shared::kTerrainBorderTexels - 1e-6;
  CHECK((b.west_deg - g.west_deg) / g.lon_step_deg >= kBorder);
  CHECK((g.north_deg - b.north_deg) / g.lat_step_deg >= kBorder);
  CHECK((g.west_deg - b.east_deg) / g.lon_step_deg + kTexels >= kBorder);
  CHECK((b.south_deg - g.north_deg) / g.lat_step_deg + kTexels >= kBorder);
}

}  // namespace

TEST_CASE("imagery grid: texels are the picture's pixels where a tile has as many") {
  for (const double lon : {178.0, -178.0}) {
    CAPTURE(lon);
    const TileId tile = tile_at(6, 45.0, lon);  // 2.8125 degrees: 229 pixels across, 278 down
    const ImageryGrid g = imagery_grid(tile, kPicture);
    check_holds_tile(g, tile);
    CHECK(g.lon_step_deg == doctest::Approx(kPicture.lon_deg));
    CHECK(g.lat_step_deg == doctest::Approx(2.0 * kPicture.lat_deg));
    const double west = lon > 0.0 ? kPicture.west_deg : kPicture.west_deg - 360.0;
    for (const double x : g.lons_deg()) CHECK(from_centre(x, west, kPicture.lon_deg) < 1e-9);
    for (const double y : g.lats_deg()) CHECK(from_centre(kPicture.north_deg - y, 0.0, 2.0 * kPicture.lat_deg) < 1e-9);
    CHECK(g.coarse_deg == doctest::Approx(2.0 * kPicture.lat_deg));
    CHECK_FALSE(g.parts);
  }
}

TEST_CASE("imagery grid: finer texels are parts of a pixel and hit its centre") {
  for (const uint32_t level : {8u, 9u, 13u, 18u}) {
    CAPTURE(level);
    const TileId tile = tile_at(level, 45.0, 178.0);
    const ImageryGrid g = imagery_grid(tile, kPicture);
    check_holds_tile(g, tile);
    CHECK(g.parts);
    CHECK(g.coarse_deg == 0.0);
    const double n = kPicture.lon_deg / g.lon_step_deg;
    CHECK(n == doctest::Approx(std::round(n)));
    // The pixel's centre nearest to the tile's corner is a texel's centre.
    const double centre =
        kPicture.west_deg +
        (std::round((tile_bounds(tile).west_deg - kPicture.west_deg) / kPicture.lon_deg) + 0.5) * kPicture.lon_deg;
    CHECK(from_centre(centre, g.west_deg, g.lon_step_deg) < 1e-4);
    // Three fifths of the image at least are used.
    CHECK(tile_size_deg(level) / g.lon_step_deg > 0.6 * kTexels);
    CHECK(g.detail_log2 == doctest::Approx(std::log2(kPicture.lon_deg / std::sqrt(g.lon_step_deg * g.lat_step_deg))));
  }
}

TEST_CASE("imagery grid: neighbours have the same texels, and the same mips of them") {
  for (const uint32_t level : {3u, 6u, 8u}) {
    const TileId tile = tile_at(level, 40.0, 172.0), east = *tile_neighbour(tile, 1, 0);
    const ImageryGrid a = imagery_grid(tile, kPicture), b = imagery_grid(east, kPicture);
    REQUIRE(a.lon_step_deg == b.lon_step_deg);
    const double turn = tile_bounds(east).west_deg < tile_bounds(tile).west_deg ? 360.0 : 0.0;
    const double apart = (b.west_deg + turn - a.west_deg) / a.lon_step_deg / 8.0;  // texels of the coarsest mip
    CHECK(std::abs(apart - std::round(apart)) < 1e-7);
  }
}

TEST_CASE("imagery grid: tiles of a picture of the globe count its pixels from one edge") {
  // 2700 pixels are no multiple of the coarsest mip's texels.
  const PixelLattice globe{.west_deg = -180.0, .north_deg = 90.0, .lon_deg = 360.0 / 2700, .lat_deg = 180.0 / 1350};
  for (const uint32_t level : {1u, 2u, 4u}) {
    const TileId west = tile_at(level, 10.0, -1e-3), east = tile_at(level, 10.0, 1e-3);
    const ImageryGrid a = imagery_grid(west, globe), b = imagery_grid(east, globe);
    const double apart = (b.west_deg - a.west_deg) / a.lon_step_deg / 8.0;
    CHECK(std::abs(apart - std::round(apart)) < 1e-7);
  }
}

TEST_CASE("imagery grid: without a picture there are texels for coasts") {
  const TileId tile{4, 7, 3};
  const ImageryGrid g = imagery_grid(tile, std::nullopt);
  check_holds_tile(g, tile);
  CHECK(g.coarse_deg == 0.0);
  CHECK(tile_size_deg(4) / g.lon_step_deg > 0.9 * 240.0);
}

TEST_CASE("imagery grid: colours are averaged beyond one pixel of the source, and no sooner") {
  for (const float detail : {0.0f, 1.0f, 2.0f}) {
    CAPTURE(detail);
    CHECK(shared::terrain_colour_lod(detail - 0.5f, detail, 0.0f) == 0.0f);
    CHECK(shared::terrain_colour_lod(detail, detail, 0.0f) == 0.0f);
    CHECK(shared::terrain_colour_lod(detail + 1.0f, detail, 0.0f) == doctest::Approx(std::min(detail + 1.0f, 3.0f)));
  }
  CHECK(shared::terrain_colour_lod(0.0f, 0.0f, 0.75f) == 0.75f);
  CHECK(shared::terrain_linear(1.0f) == doctest::Approx(1.0f));
  CHECK(shared::terrain_linear(0.5f) == doctest::Approx(0.214041f));  // IEC 61966-2-1
}
