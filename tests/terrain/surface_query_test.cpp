#include "terrain/surface_query.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "terrain/imagery_sampler.h"
#include "terrain/ray_caster.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

std::shared_ptr<ArrayRaster> named(std::shared_ptr<ArrayRaster> raster, const std::string& path) {
  RasterInfo info = raster->info();
  info.path = path;
  std::vector<float> values;
  const Result<RasterBlock> block = raster->read_block(0, 0, 0);
  REQUIRE(block->width == info.width);
  REQUIRE(block->height == info.height);
  return std::make_shared<ArrayRaster>(info, block->values);
}

/// Four bands of one picture, 0..255.
std::shared_ptr<ArrayRaster> picture_of(uint32_t width, uint32_t height, LonLatBounds bounds,
                                        const std::function<glm::vec3(double lat, double lon)>& f) {
  RasterInfo info;
  info.path = "picture";
  info.width = width;
  info.height = height;
  info.bands = 4;
  info.bounds = bounds;
  info.wraps = bounds.east_deg - bounds.west_deg == 360.0;
  std::vector<float> values;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec3 c = f(bounds.north_deg - (bounds.north_deg - bounds.south_deg) * (y + 0.5) / height,
                            bounds.west_deg + (bounds.east_deg - bounds.west_deg) * (x + 0.5) / width);
      values.insert(values.end(), {c.r, c.g, c.b, 255.0f});
    }
  return std::make_shared<ArrayRaster>(info, std::move(values));
}

SurfacePoint at(const HeightSampler& ground, double lat_deg, double lon_deg) {
  return surface_at(ground, rad_from_deg(lat_deg), rad_from_deg(lon_deg));
}

}  // namespace

TEST_CASE("a ray meets a triangle inside and on its edges, from both sides, and not beside it") {
  const dvec3 a(0, 0, 5), b(4, 0, 5), c(0, 4, 5);
  const auto hit = [&](double x, double y) { return ray_triangle(a, b, c, dvec3(x, y, 5.0) / 5.0); };
  REQUIRE(hit(1, 1).has_value());
  CHECK(*hit(1, 1) == doctest::Approx(5.0).epsilon(1e-15));
  CHECK(hit(0, 0).has_value());
  CHECK(hit(2, 2).has_value());
  CHECK(hit(0, 3).has_value());
  CHECK_FALSE(hit(-1e-9, 1).has_value());
  CHECK_FALSE(hit(2.1, 2.0).has_value());
  CHECK(ray_triangle(a, c, b, dvec3(0.2, 0.2, 1.0)).has_value());
  CHECK(*ray_triangle(a, b, c, dvec3(-0.2, -0.2, -1.0)) < 0.0);  // behind
  CHECK_FALSE(ray_triangle(a, b, c, dvec3(1, 0, 0)).has_value());
}

TEST_CASE("no ray slips between triangles that share an edge") {
  uint32_t state = 7;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / 16777216.0;
  };
  for (int i = 0; i < 20000; ++i) {
    // A fan around a vertex, seen from afar; the ray aims at its spokes.
    const dvec3 centre(random() * 1e7, random() * 1e7, 3e7 + random() * 1e7);
    dvec3 rim[6];
    for (int k = 0; k < 6; ++k) rim[k] = centre + 500.0 * dvec3(std::cos(k), std::sin(k), 0.2 * random());
    const int spoke = 1 + i % 4;
    const dvec3 dir = glm::normalize(glm::mix(centre, rim[spoke], 0.05 + 0.9 * random()));
    int hits = 0;
    for (int k = 0; k < 5; ++k) hits += ray_triangle(centre, rim[k], rim[k + 1], dir).has_value();
    REQUIRE(hits >= 1);
  }
}

TEST_CASE("surface: a plane's height and slope come back at any place, whatever the mesh") {
  // 1500 m + 20,000 m per degree of latitude - 11,000 m per degree of longitude, about a place on the equator.
  const auto plane = [](double lat, double lon) { return 1500.0 + 20000.0 * lat - 11000.0 * (lon - 10.0); };
  const auto raster =
      named(raster_of(64, 64, {9.95, -0.05, 10.05, 0.05}, plane, VerticalDatum::ellipsoid), "/x/plane.tif");
  const HeightSampler ground({raster}, false, nullptr);
  const Ellipsoid e;
  const double meridian_m = std::numbers::pi / 180.0 * e.b_m * e.b_m / e.a_m,
               parallel_m = std::numbers::pi / 180.0 * e.a_m;
  const double slope = std::atan(std::hypot(20000.0 / meridian_m, 11000.0 / parallel_m));
  for (const auto& [lat, lon] : {std::pair{0.0, 10.0}, {0.0123456, 10.0234567}, {-0.031, 9.9712345}, {0.02, 369.98}}) {
    const SurfacePoint p = at(ground, lat, lon);
    CHECK(p.height_m ==
          doctest::Approx(plane(lat, lon > 180 ? lon - 360 : lon)).epsilon(1e-6));  // floats of the raster
    CHECK(p.height_msl_m == p.height_m);
    CHECK(p.slope_rad == doctest::Approx(slope).epsilon(2e-3));  // 1.5 km up the same slope is 0.02 % longer
    CHECK(p.source == "plane.tif");
    CHECK_FALSE(p.sea);
  }
  const SurfacePoint beside = at(ground, 1.0, 10.0);
  CHECK(std::abs(beside.height_m) < 1e-7);
  CHECK(beside.slope_rad < 1e-6);
  CHECK(beside.source == "ellipsoid");
}

TEST_CASE("surface: the source is the raster with the largest share; the sea is the geoid") {
  const auto world = named(raster_of(256, 128, {}, [](double, double lon) { return lon < 0.0 ? -4000.0 : 300.0; }),
                           R"(NETCDF:"/data/world.cdf":ROSE)");
  const auto low = named(raster_of(16, 16, {-2.0, -2.0, 2.0, 2.0}, [](double, double) { return 40.0; }), "a/dem.tif");
  const auto high = named(raster_of(16, 16, {0.0, -2.0, 2.0, 2.0}, [](double, double) { return 70.0; }), "b/dem.tif");
  const auto geoid = std::make_shared<const Geoid>(Geoid::egm96());
  const HeightSampler ground({world, low, high}, true, geoid);
  CHECK(at(ground, 10.0, -50.0).source == "world.cdf");
  CHECK(at(ground, 10.0, -50.0).sea);
  CHECK(std::abs(at(ground, 10.0, -50.0).height_msl_m) < 1e-3);
  CHECK(at(ground, 10.0, -50.0).height_m ==
        doctest::Approx(geoid->undulation_m(rad_from_deg(10.0), rad_from_deg(-50.0))).epsilon(1e-4));
  CHECK(at(ground, 10.0, 50.0).height_msl_m == doctest::Approx(300.0).epsilon(1e-6));
  CHECK(at(ground, 0.5, -1.0).source == "a/dem.tif");  // two of that name: the whole path
  CHECK(at(ground, 0.5, 1.0).source == "b/dem.tif");
  CHECK(at(ground, 0.5, 1.0).height_msl_m == doctest::Approx(70.0).epsilon(1e-6));
  // The upper raster fades out over the pixel (0.25 degrees) around its edge.
  CHECK(at(ground, 0.5, 0.03).source == "b/dem.tif");
  CHECK(at(ground, 0.5, -0.03).source == "a/dem.tif");
}

TEST_CASE("surface: a pole and the antimeridian are one place from all sides") {
  const HeightSampler ground({rough_world(256)}, false, nullptr);
  for (const double lat : {90.0, -90.0}) {
    const SurfacePoint first = at(ground, lat, 0.0);
    for (const double lon : {-180.0, -77.7, 12.3, 180.0, 300.0})
      CHECK(at(ground, lat, lon).height_m == doctest::Approx(first.height_m).epsilon(1e-9));
    // Continuous up to it: 1 m away, on ground that rises by less than 1:1.
    CHECK(std::abs(at(ground, std::copysign(90.0 - 1e-5, lat), 40.0).height_m - first.height_m) < 2.0);
  }
  for (const double lat : {-60.0, 0.0, 33.3})
    CHECK(at(ground, lat, 180.0).height_m == at(ground, lat, -180.0).height_m);
}

TEST_CASE("surface: heights lie on the finest mesh: vertices are the sampler's, edges and diagonals are straight") {
  const HeightSampler ground({rough_world(256)}, false, nullptr);
  const uint32_t level = finest_level_at(41.0, 7.0);
  CHECK(level == kMaxTerrainLevel);
  const double s = vertex_spacing_deg(level);
  const double lat = std::floor(41.0 / s) * s, lon = std::floor(7.0 / s) * s;  // a vertex
  const auto h = [&](double y, double x) { return at(ground, lat + y * s, lon + x * s).height_m; };
  const double sw = ground.height_m(rad_from_deg(lat), rad_from_deg(lon), level);
  CHECK(h(0, 0) == doctest::Approx(sw).epsilon(1e-9));
  // Within 1.2 m the curvature of the Earth is 30 nm.
  CHECK(h(0.0, 0.5) == doctest::Approx(0.5 * (h(0, 0) + h(0, 1))).epsilon(1e-9));
  CHECK(h(0.5, 0.5) == doctest::Approx(0.5 * (h(1, 1) + h(0, 0))).epsilon(1e-9));  // north-east to south-west
}

TEST_CASE("the deepest level is less around the poles") {
  CHECK(finest_level_at(89.9, 10.0) == 6);
  CHECK(finest_level_at(-88.0, 10.0) == 6);
  CHECK(finest_level_at(60.0, 10.0) == kMaxTerrainLevel);
}

TEST_CASE("sources are called by their file") {
  CHECK(source_file_name("../shared/data/dem/mt_fuji_90m.tif") == "mt_fuji_90m.tif");
  CHECK(source_file_name("fuji.tif") == "fuji.tif");
  CHECK(source_file_name(R"(NETCDF:"/usr/share/etopo5.cdf":ROSE)") == "etopo5.cdf");
  CHECK(source_file_name("GPKG:/a/b.gpkg:dem") == "b.gpkg");
  CHECK(source_file_name("/vsizip//a/b.zip/c.hgt") == "c.hgt");
  CHECK(source_file_name("/a/tiles/") == "tiles");
  CHECK(source_file_name("https://host:80/a/{z}/{x}/{y}.png") == "https://host:80/a/{z}/{x}/{y}.png");
  CHECK(source_file_name("/vsicurl/http://127.0.0.1:8080/d/e.tif?x=1") == "e.tif");
}

TEST_CASE("water mask: white is water at its own height, black is land, and beyond it elevation decides") {
  const auto world = raster_of(720, 360, {}, [](double, double lon) { return lon > 0.0 ? 400.0 : -50.0; });
  HeightSampler ground({world}, true, nullptr);
  // Covers 10 degrees to both sides of the coast; a lake in the east, an island in the west.
  ground.set_water_mask(picture_of(80, 80, {-10.0, -10.0, 10.0, 10.0}, [](double lat, double lon) {
    const bool lake = std::hypot(lat, lon - 5.0) < 2.0, island = std::hypot(lat, lon + 5.0) < 2.0;
    return glm::vec3((lon < 0.0 && !island) || lake ? 255.0f : 0.0f);
  }));
  const double lats[] = {0.0}, lons[] = {-20.0, -8.0, -5.0, 3.6, 5.0, 8.0, 20.0};
  const bool land[] = {false, false, true, false, false, true, true};
  float field[7];
  ground.land_field_m(lats, lons, 0.01, field);
  for (size_t i = 0; i < 7; ++i) {
    CAPTURE(lons[i]);
    CHECK((field[i] > 0.0f) == land[i]);
  }
  // The mask says what there is, not how high.
  CHECK(surface_height_m(ground, 0.0, rad_from_deg(5.0)) == doctest::Approx(400.0).epsilon(1e-6));
  CHECK(std::abs(surface_height_m(ground, 0.0, rad_from_deg(-5.0))) < 1e-6);
  // The shore of the lake lies half way between the mask's pixel centres around it: (3.125, 2.875).
  const double shore[] = {2.99, 3.01};
  float f[2];
  ground.land_field_m(lats, shore, 0.001, f);
  CHECK(f[0] > 0.0f);
  CHECK(f[1] <= 0.0f);
}

TEST_CASE("ice: bright and colourless pictures over cold seas are ice; clouds over warm ones are not") {
  const float ice[] = {250, 251, 255}, old[] = {160, 170, 180}, sea[] = {10, 20, 60}, shoal[] = {90, 150, 160};
  CHECK(ice_field(ice, 80.0) > 0.0f);
  CHECK(ice_field(ice, -55.0) > 0.0f);
  CHECK(ice_field(old, 75.0) > 0.0f);
  CHECK(ice_field(sea, 80.0) <= 0.0f);
  CHECK(ice_field(shoal, 80.0) <= 0.0f);
  CHECK(ice_field(ice, 24.0) <= 0.0f);
  CHECK(ice_field(ice, -44.9) <= 0.0f);
  // The picture as it is decides, not the land's colours that were painted over the sea around it.
  const auto world =
      raster_of(720, 360, {}, [](double lat, double) { return lat > 70.0 && lat < 72.0 ? 300.0 : -50.0; });
  const HeightSampler ground({world}, true, nullptr);
  const ImagerySampler imagery(
      {picture_of(720, 360, {},
                  [&](double lat, double) { return lat > 70.0 ? glm::vec3(250.0f) : glm::vec3(10, 20, 60); })},
      ground);
  const double lats[] = {80.0, 71.0, 68.0, 50.0}, lons[] = {10.0};
  float found[4];
  imagery.over_water(lats, lons, 0.1, found);
  CHECK(found[0] > 0.0f);
  CHECK(found[2] <= 0.0f);
  CHECK(found[3] <= 0.0f);
  float rgbx[16];
  imagery.colours(lats, lons, 0.1, rgbx);
  CHECK(rgbx[0] == 250.0f);  // ice keeps its colour
  CHECK(rgbx[8] > 240.0f);   // the sea beside it got the land's
}

TEST_CASE("a map with white seas freezes no sea, and hides no ice of the picture below") {
  const auto world = raster_of(720, 360, {}, [](double, double lon) { return lon < 0.0 ? 300.0 : -50.0; });
  const HeightSampler ground({world}, true, nullptr);
  const auto photo = picture_of(
      720, 360, {}, [](double lat, double) { return lat > 70.0 ? glm::vec3(250.0f) : glm::vec3(10, 20, 60); });
  const auto map =
      picture_of(720, 360, {}, [](double, double lon) { return lon < 0.0 ? glm::vec3(235.0f) : glm::vec3(255.0f); });
  const double lats[] = {80.0, 60.0}, lons[] = {30.0};
  float found[2];
  ImagerySampler({map}, ground).over_water(lats, lons, 0.1, found);
  CHECK(found[0] <= 0.0f);
  CHECK(found[1] <= 0.0f);
  ImagerySampler({photo, map}, ground).over_water(lats, lons, 0.1, found);
  CHECK(found[0] > 0.0f);
  CHECK(found[1] <= 0.0f);
  // A polar picture that is all ice is believed: it shows no warm sea.
  ImagerySampler({picture_of(360, 60, {-180, 60, 180, 90}, [](double, double) { return glm::vec3(250.0f); })}, ground)
      .over_water(lats, lons, 0.1, found);
  CHECK(found[0] > 0.0f);
}

TEST_CASE("a picture much finer than elevation shows what it has over the sea, but for deep water") {
  const float sea[] = {10, 20, 60}, noise[] = {4, 8, 6}, bank[] = {60, 150, 190}, cloud[] = {220, 220, 225},
              forest[] = {25, 45, 20};
  CHECK(shore_field(sea) <= 0.0f);
  CHECK(shore_field(noise) <= 0.0f);
  for (const float* shown : {bank, cloud, forest}) CHECK(shore_field(shown) > 0.0f);
  const auto world = raster_of(720, 360, {}, [](double, double) { return -50.0; });
  const HeightSampler ground({world}, true, nullptr);
  const auto island = [](double lat, double lon) {
    return std::hypot(lat, lon) < 0.5 ? glm::vec3(25, 45, 20) : glm::vec3(10, 20, 60);
  };
  const double lats[] = {0.0}, lons[] = {0.0, 0.7, 5.0};
  float found[3];
  ImagerySampler({picture_of(200, 200, {-1, -1, 1, 1}, island)}, ground).over_water(lats, lons, 0.01, found);
  CHECK(found[0] > 0.0f);
  CHECK(found[1] <= 0.0f);
  CHECK(found[2] <= 0.0f);
  // One that is hardly finer than the elevation's half degrees says nothing.
  ImagerySampler({picture_of(10, 10, {-1, -1, 1, 1}, island)}, ground).over_water(lats, lons, 0.01, found);
  CHECK(found[0] <= 0.0f);
}
