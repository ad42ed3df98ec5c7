#include "common/region_map.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace nepho;
using glm::dvec2;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using shared::RegionMap;

namespace {

constexpr double kRadius_m = 6378137.0;
constexpr double kPi = 3.14159265358979323846;

RegionMap map_at(double lat_deg, double lon_deg) {
  const double lat = lat_deg * kPi / 180.0, lon = lon_deg * kPi / 180.0;
  RegionMap map;
  map.centre = vec3(dvec3(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)));
  map.east = vec3(dvec3(-std::sin(lon), std::cos(lon), 0.0));
  map.north = vec3(dvec3(-std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat)));
  map.half_m = 10000.0f;
  map.radius_m = static_cast<float>(kRadius_m);
  map.levels = 11;
  return map;
}

std::vector<RegionMap> maps() {
  return {map_at(0.0, 0.0), map_at(35.4, 138.7), map_at(-60.0, 180.0), map_at(90.0, 0.0), map_at(-90.0, 30.0)};
}

/// The direction at an angle from the centre, towards an azimuth counted from east to north.
dvec3 direction_at(const RegionMap& map, double angle, double azimuth) {
  return dvec3(map.centre) * std::cos(angle) +
         (dvec3(map.east) * std::cos(azimuth) + dvec3(map.north) * std::sin(azimuth)) * std::sin(angle);
}

}  // namespace

TEST_CASE("a place on the plane and its direction are each other's inverse from 10 m to 9000 km") {
  for (const RegionMap& map : maps())
    for (double r = 10.0; r < 9.1e6; r *= 1.7)
      for (double azimuth = 0.1; azimuth < 6.2; azimuth += 0.5) {
        const vec2 xy(dvec2(std::cos(azimuth), std::sin(azimuth)) * r);
        const vec3 dir = shared::region_direction(map, xy);
        REQUIRE(std::abs(glm::length(dvec3(dir)) - 1.0) < 2e-7);
        // A unit vector of floats knows a place to half a metre.
        const double off = glm::length(dvec2(shared::region_xy(map, dir)) - dvec2(xy));
        CAPTURE(r);
        REQUIRE(off < 1.5 + 5e-7 * r);
      }
}

TEST_CASE("the radius on the plane is 2 R sin(theta / 2), and the azimuth is kept") {
  for (const RegionMap& map : maps())
    for (const double angle : {1e-5, 1e-3, 0.1, 1.0, 1.6, 2.5, 3.0, 3.1, 3.13})
      for (double azimuth = -3.0; azimuth < 3.1; azimuth += 0.7) {
        CAPTURE(angle);
        CAPTURE(azimuth);
        const dvec2 xy(shared::region_xy(map, vec3(direction_at(map, angle, azimuth))));
        const double r = 2.0 * kRadius_m * std::sin(0.5 * angle);
        CHECK(std::abs(glm::length(xy) - r) < 1.5 + 5e-7 * r);
        // Sideways a float's rounding of the direction weighs the more, the closer the antipode.
        const double side = std::remainder(std::atan2(xy.y, xy.x) - azimuth, 2.0 * kPi) * r;
        CHECK(std::abs(side) < (1.5 + 5e-7 * r) / std::cos(0.5 * angle));
      }
}

TEST_CASE("places around the antipode end at the rim, not at the centre") {
  for (const RegionMap& map : maps()) {
    for (const double angle : {3.0, 3.1, 3.14, 3.1415, 3.14159, kPi}) {
      const dvec2 xy(shared::region_xy(map, vec3(direction_at(map, angle, 1.0))));
      CHECK(glm::length(xy) == doctest::Approx(2.0 * kRadius_m * std::sin(0.5 * angle)).epsilon(1e-4));
    }
    CHECK(shared::region_level(map, shared::region_xy(map, -map.centre)) == map.levels);
    const vec3 beyond = shared::region_direction(map, vec2(3e7f, -1e7f));
    CHECK(glm::length(dvec3(beyond) + dvec3(map.centre)) < 1e-6);
  }
}

TEST_CASE("equal areas of the sphere are equal areas of the map") {
  // The solid angle of a small square, from the directions of its corners.
  for (const RegionMap& map : maps())
    for (const double r : {0.0, 5e5, 2e6, 6e6, 9e6, 1.2e7})
      for (const double azimuth : {0.3, 2.0, 4.4}) {
        const dvec2 at = dvec2(std::cos(azimuth), std::sin(azimuth)) * r;
        const double side = 50e3;
        const auto place = [&](double x, double y) {
          return dvec3(shared::region_direction(map, vec2(at + dvec2(x, y) * side))) * kRadius_m;
        };
        const double area =
            0.5 * glm::length(glm::cross(place(0.5, 0.5) - place(-0.5, -0.5), place(-0.5, 0.5) - place(0.5, -0.5)));
        CAPTURE(r);
        CHECK(area == doctest::Approx(side * side).epsilon(2e-4));
      }
}

TEST_CASE("distances are lengthened by no more than the stretch, and by it across the radius") {
  const RegionMap map = map_at(35.4, 138.7);
  for (const double angle : {0.01, 0.5, 1.0, 1.5, 2.0}) {
    const double azimuth = 0.7, step = 1e-2;
    const vec3 dir(direction_at(map, angle, azimuth));
    const double stretch = static_cast<double>(shared::region_stretch(map, dir));
    CHECK(stretch == doctest::Approx(1.0 / std::cos(0.5 * angle)).epsilon(1e-5));
    const auto length_to = [&](const dvec3& other) {
      const double real = glm::length(other - direction_at(map, angle, azimuth)) * kRadius_m;
      return glm::length(dvec2(shared::region_xy(map, vec3(other))) - dvec2(shared::region_xy(map, dir))) / real;
    };
    CHECK(length_to(direction_at(map, angle, azimuth + step)) == doctest::Approx(stretch).epsilon(1e-3));
    CHECK(length_to(direction_at(map, angle + step, azimuth)) == doctest::Approx(1.0 / stretch).epsilon(1e-2));
  }
}

TEST_CASE("each level is twice as wide as the one before, and the finest that holds a place is found") {
  const RegionMap map = map_at(0.0, 0.0);
  for (uint32_t level = 0; level < map.levels; ++level) {
    const float half = shared::region_half_m(map, level);
    CHECK(half == std::ldexp(10000.0f, static_cast<int>(level)));
    for (const float sign : {-1.0f, 1.0f}) {
      CHECK(shared::region_level(map, vec2(sign * half * 0.999f, 0.0f)) == level);
      CHECK(shared::region_level(map, vec2(0.0f, sign * half)) == level + 1);
      CHECK(shared::region_level(map, vec2(half * 0.7f, sign * half * 0.999f)) == level);
    }
  }
  CHECK(shared::region_level(map, vec2(0.0f)) == 0);
  CHECK(shared::region_level(map, vec2(1e9f)) == map.levels);
}
