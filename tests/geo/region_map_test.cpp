#include "geo/region_map.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <initializer_list>

using namespace nepho;
using glm::dvec2;
using glm::vec2;

namespace {

struct Place {
  double lat_deg, lon_deg;
};
constexpr Place kPlaces[] = {{0.0, 0.0},    {35.36, 138.73}, {-45.0, 180.0}, {-45.0, -179.9999},
                             {89.9999, 40}, {90.0, 0.0},     {-90.0, 0.0}};

dvec3 ecef(double lat_deg, double lon_deg, double height_m = 0.0) {
  return ecef_from_geodetic(Geodetic::from_degrees(lat_deg, lon_deg, height_m));
}

}  // namespace

TEST_CASE("a region map stands at its place, with right-handed unit axes, at the poles too") {
  for (const Place& p : kPlaces) {
    const shared::RegionMap map = make_region_map(ecef(p.lat_deg, p.lon_deg, 3000.0), 10e3, 11);
    const dvec3 c(map.centre), e(map.east), n(map.north);
    CHECK(glm::length(c - map_direction_from_ecef(ecef(p.lat_deg, p.lon_deg))) < 2e-6);  // the height tilts by 1e-6
    for (const dvec3& v : {c, e, n}) CHECK(glm::length(v) == doctest::Approx(1.0).epsilon(1e-7));
    CHECK(glm::length(glm::cross(e, n) - c) < 2e-7);
    CHECK(std::abs(e.z) < 1e-12);
    CHECK(map.half_m == 10e3f);
    CHECK(map.levels == 11u);
    CHECK(map.radius_m == 6378137.0f);
  }
}

TEST_CASE("x of a region map grows to the east and y to the north, in metres, across the antimeridian too") {
  for (const Place& p : {Place{0.0, 0.0}, Place{0.0, 180.0}, Place{0.0, -179.9999}}) {
    const shared::RegionMap map = make_region_map(ecef(p.lat_deg, p.lon_deg), 10e3, 11);
    const auto xy = [&](double lat_deg, double lon_deg) {
      return dvec2(shared::region_xy(map, glm::vec3(map_direction_from_ecef(ecef(lat_deg, lon_deg)))));
    };
    // A hundredth of a degree of the equator; north of it a scaled degree is 0.67 % longer than a metre's worth.
    const double metres = rad_from_deg(0.01) * 6378137.0;
    CHECK(xy(0.0, p.lon_deg + 0.01).x == doctest::Approx(metres).epsilon(1e-3));
    CHECK(std::abs(xy(0.0, p.lon_deg + 0.01).y) < 1.0);
    CHECK(xy(0.01, p.lon_deg).y == doctest::Approx(metres * (1.0 - 1.0 / 298.257)).epsilon(1e-3));
    CHECK(std::abs(xy(0.01, p.lon_deg).x) < 1.0);
  }
  // At the poles east is that of longitude 0.
  const shared::RegionMap north = make_region_map({0.0, 0.0, 6.4e6}, 10e3, 11);
  CHECK(shared::region_xy(north, glm::vec3(map_direction_from_ecef(ecef(89.0, 90.0)))).x > 1e5f);
  CHECK(shared::region_xy(north, glm::vec3(map_direction_from_ecef(ecef(89.0, 180.0)))).y > 1e5f);
}

TEST_CASE("the place of a map direction has its latitude and longitude") {
  for (const Place& p : kPlaces) {
    const Geodetic g = geodetic_from_map_direction(map_direction_from_ecef(ecef(p.lat_deg, p.lon_deg)));
    CHECK(g.lat_deg() == doctest::Approx(p.lat_deg).epsilon(1e-12));
    if (std::abs(p.lat_deg) < 90.0) CHECK(std::abs(std::remainder(g.lon_deg() - p.lon_deg, 360.0)) < 1e-9);
    CHECK(g.height_m == 0.0);
  }
  const Ellipsoid sphere = Ellipsoid::sphere(1e6);
  CHECK(geodetic_from_map_direction(glm::normalize(dvec3(1, 0, 1)), sphere).lat_deg() == doctest::Approx(45.0));
}
