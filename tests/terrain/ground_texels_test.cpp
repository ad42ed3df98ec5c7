#include "terrain/ground_texels.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "ground_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr uint32_t kSide = GroundTexels::kSide;
constexpr double kPlaces[][2] = {{0.0, 0.0},     {35.4, 138.7}, {-17.0, 179.99},
                                 {52.0, -180.0}, {90.0, 0.0},   {-89.95, 60.0}};

size_t index(uint32_t level, uint32_t i, uint32_t j) { return (size_t{level} * kSide + j) * kSide + i; }

}  // namespace

TEST_CASE("the ground map of the plain ellipsoid is bare land at height 0") {
  for (const double bare : {0.0, 0.2, 0.7}) {
    const HeightSampler heights({}, false, nullptr);
    const ImagerySampler imagery({}, heights, bare);
    const GroundTexels texels = sample_ground(heights, imagery, map_at(35.0, 179.9, 3, 2.56e6));
    REQUIRE(texels.albedo.size() == 3 * kSide * kSide);
    REQUIRE(texels.height_m.size() == 3 * kSide * kSide);
    for (const glm::vec4& a : texels.albedo) {
      REQUIRE(a.a == 1.0f);
      for (int c = 0; c < 3; ++c) REQUIRE(static_cast<double>(a[c]) == doctest::Approx(bare).epsilon(1e-5));
    }
    for (const float h : texels.height_m) REQUIRE(h == 0.0f);
  }
}

TEST_CASE("texels of the ground map hold the rasters' heights and colours at their places, on every level") {
  const HeightSampler heights({smooth_elevation()}, true, nullptr);
  const ImagerySampler imagery({smooth_imagery()}, heights);
  for (const auto& place : kPlaces) {
    const shared::RegionMap map = map_at(place[0], place[1]);
    const GroundTexels texels = sample_ground(heights, imagery, map);
    for (uint32_t level = 0; level < map.levels; ++level)
      for (uint32_t j = 0; j < kSide; j += 9)
        for (uint32_t i = 0; i < kSide; i += 9) {
          Geodetic at;
          if (!texel_place(map, level, i, j, at)) continue;
          const dvec3 up = geodetic_up_ecef(at.lat_rad, at.lon_rad);
          CAPTURE(place[0]);
          CAPTURE(level);
          CAPTURE(at.lat_deg());
          CAPTURE(at.lon_deg());
          REQUIRE(static_cast<double>(texels.height_m[index(level, i, j)]) ==
                  doctest::Approx(smooth_height_m(up)).epsilon(4e-3));
          const glm::vec4& albedo = texels.albedo[index(level, i, j)];
          REQUIRE(albedo.a == 1.0f);
          for (int c = 0; c < 3; ++c)
            REQUIRE(static_cast<double>(albedo[c]) == doctest::Approx(linear_from_srgb(smooth_srgb(up))).epsilon(5e-3));
        }
  }
}

TEST_CASE("near the place the ground map follows rough ground as it is drawn") {
  const HeightSampler heights({rough_world()}, true, nullptr);
  const ImagerySampler imagery({}, heights);
  for (const auto& place : kPlaces) {
    const shared::RegionMap map = map_at(place[0], place[1], 4);
    const GroundTexels texels = sample_ground(heights, imagery, map);
    for (uint32_t level = 0; level < map.levels; ++level)
      for (uint32_t j = 0; j < kSide; j += 13)
        for (uint32_t i = 0; i < kSide; i += 13) {
          Geodetic at;
          REQUIRE(texel_place(map, level, i, j, at));
          // Next to a pole the pixels of this raster are as narrow as the texels: all slopes are possible.
          if (std::abs(at.lat_deg()) > 89.0) continue;
          const double drawn = heights.height_m(at.lat_rad, at.lon_rad, kMaxTileLevel);
          // 4000 m within a pixel is the steepest there is.
          const double slope = 4000.0 / (55600.0 * std::cos(at.lat_rad));
          CAPTURE(place[0]);
          CAPTURE(level);
          REQUIRE(std::abs(static_cast<double>(texels.height_m[index(level, i, j)]) - drawn) <
                  0.01 + slope * texel_m(map, level));
        }
  }
}

TEST_CASE("a straight coast parts the ground map where it runs, and the sea's colour stays out of the land's") {
  // Land of 100 m east of Greenwich, in white; the sea is black and 100 m deep.
  const auto world = raster_of(3600, 1800, {}, [](double, double lon) { return lon > 0.0 ? 100.0 : -100.0; });
  const auto picture = raster_of(3600, 1800, {}, [](double, double lon) { return lon > 0.0 ? 255.0 : 0.0; });
  const HeightSampler heights({world}, true, nullptr);
  const ImagerySampler imagery({picture}, heights);
  const shared::RegionMap map = map_at(10.0, 0.0, 9);
  const GroundTexels texels = sample_ground(heights, imagery, map);
  for (uint32_t level = 0; level < map.levels; ++level)
    for (const uint32_t j : {10u, 64u, 120u}) {
      CAPTURE(level);
      CAPTURE(j);
      double land_texels = 0.0;
      for (uint32_t i = 0; i < kSide; ++i) {
        const glm::vec4& a = texels.albedo[index(level, i, j)];
        land_texels += static_cast<double>(a.a);
        // Blue Marble's own coast: the picture's grey pixel there is painted over. 1 % is sRGB's rounding.
        for (int c = 0; c < 3; ++c) REQUIRE(a[c] == doctest::Approx(a.a).epsilon(0.01));
        if (i < 63) REQUIRE(a == glm::vec4(0.0f));
        if (i > 64) REQUIRE(a.a == 1.0f);
        // The surface of the sea is the geoid (here the ellipsoid), that of the land is no higher than 100 m.
        const float h = texels.height_m[index(level, i, j)];
        if (i < 63) REQUIRE(h == 0.0f);
        REQUIRE(h >= 0.0f);
        REQUIRE(h <= 100.001f);
      }
      CHECK(land_texels == doctest::Approx(kSide / 2.0).epsilon(0.01));
    }
}

TEST_CASE("coarse levels keep the share of islands far smaller than their texels, in a deep sea") {
  // A quarter of all longitudes is land of 100 m, in strips of two pixels of an eighth of a degree; the sea is 400 m
  // deep. Mean heights are below 0. Between pixels 4/5 of the slope is under water: 0.3 pixels less of land at each
  // shore.
  const auto world = raster_of(2880, 1440, {}, [](double, double lon) {
    return std::fmod(std::floor((lon + 180.0) * 4.0), 4.0) == 0.0 ? 100.0 : -400.0;
  });
  const HeightSampler heights({world}, true, nullptr);
  const ImagerySampler imagery({}, heights);
  const shared::RegionMap map = map_at(0.0, 20.0, 11);
  const GroundTexels texels = sample_ground(heights, imagery, map);
  for (const uint32_t level : {8u, 9u, 10u}) {
    double land = 0.0;
    for (uint32_t j = 32; j < 96; ++j)
      for (uint32_t i = 32; i < 96; ++i)
        land += static_cast<double>(texels.albedo[index(level, i, j)].a) / (64.0 * 64.0);
    CAPTURE(level);
    CHECK(land == doctest::Approx(0.25 * 1.4 / 2.0).epsilon(0.1));
  }
}
