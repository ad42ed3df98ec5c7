#include "geo/geodetic.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "oracles/oracle_table.h"

using namespace nepho;
using nepho::test::oracle_table;

TEST_CASE("geodetic to ECEF agrees with GeographicLib's table within 1 um, poles and antimeridian included") {
  const auto rows = oracle_table("geodetic_ecef");
  REQUIRE(rows.size() >= 200);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const dvec3 p = ecef_from_geodetic(
        Geodetic::from_degrees(row.number("lat_deg"), row.number("lon_deg"), row.number("height_m")));
    CHECK(glm::length(p - dvec3(row.number("x_m"), row.number("y_m"), row.number("z_m"))) < 1e-6);
  }
}

TEST_CASE("ECEF to geodetic agrees with the table: 1e-11 degrees and 1 um, deep inside too") {
  const auto rows = oracle_table("ecef_to_geodetic");
  REQUIRE(rows.size() >= 100);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const Geodetic at = geodetic_from_ecef(dvec3(row.number("x_m"), row.number("y_m"), row.number("z_m")));
    const double tolerance_deg = row.text("category") == "deep_inside" ? 1e-9 : 1e-11;  // ill-conditioned there
    CHECK(std::abs(at.height_m - row.number("height_m")) < 1e-6);
    CHECK(std::abs(at.lat_deg() - row.number("lat_deg")) < tolerance_deg);
    if (std::abs(row.number("lat_deg")) < 89.9999)
      CHECK(std::abs(std::remainder(at.lon_deg() - row.number("lon_deg"), 360.0)) < tolerance_deg);
  }
}

TEST_CASE("geodetic to ECEF and back agrees within 1 um from -11 km to 40,000 km") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Geodetic at{std::asin(2.0 * unit(random) - 1.0), (2.0 * unit(random) - 1.0) * std::numbers::pi,
                      i % 2 ? -11e3 + 31e3 * unit(random) : std::pow(10.0, 7.602 * unit(random))};
    const dvec3 p = ecef_from_geodetic(at);
    const dvec3 back = ecef_from_geodetic(geodetic_from_ecef(p));
    REQUIRE(glm::length(back - p) < 1e-6);
    REQUIRE(std::abs(geodetic_from_ecef(p).height_m - at.height_m) < 1e-6);
  }
}

TEST_CASE("at 0N 0E ECEF is (a, 0, 0), at the north pole (0, 0, b), and at 0N 180E (-a, 0, 0)") {
  const Ellipsoid wgs84;
  CHECK(glm::length(ecef_from_geodetic({}) - dvec3(wgs84.a_m, 0, 0)) < 1e-9);
  CHECK(glm::length(ecef_from_geodetic(Geodetic::from_degrees(90, 0)) - dvec3(0, 0, wgs84.b_m)) < 1e-9);
  CHECK(glm::length(ecef_from_geodetic(Geodetic::from_degrees(0, -180)) - dvec3(-wgs84.a_m, 0, 0)) < 2e-9);
}

TEST_CASE("longitudes are brought into (-180, 180]") {
  CHECK(Geodetic::from_degrees(0, 360).lon_rad == 0.0);
  CHECK(Geodetic::from_degrees(0, 190).lon_deg() == doctest::Approx(-170.0).epsilon(1e-15));
  CHECK(Geodetic::from_degrees(0, -180).lon_rad == std::numbers::pi);
  CHECK(Geodetic::from_degrees(0, 540).lon_rad == std::numbers::pi);
}

TEST_CASE("on a sphere the height is the distance from the centre less the radius") {
  const Ellipsoid sphere = Ellipsoid::sphere(6360e3);
  const dvec3 p(3e6, -4e6, 5e6);
  const Geodetic at = geodetic_from_ecef(p, sphere);
  CHECK(std::abs(at.height_m - (glm::length(p) - 6360e3)) < 1e-8);
  CHECK(std::abs(at.lat_rad - std::asin(5e6 / glm::length(p))) < 1e-15);
  CHECK(glm::length(ecef_from_geodetic(at, sphere) - p) < 1e-8);
}

TEST_CASE("the centre of the Earth and the axis give finite places") {
  for (const dvec3& p : {dvec3(0.0), dvec3(0, 0, 1000.0), dvec3(0, 0, -6.4e6), dvec3(1.0, 0, 0)}) {
    const Geodetic at = geodetic_from_ecef(p);
    CHECK(std::isfinite(at.height_m));
    CHECK(std::abs(at.lat_rad) <= std::numbers::pi / 2);
    CHECK(glm::length(ecef_from_geodetic(at) - p) < 1e-6);
  }
}

TEST_CASE("the geodetic normal is the gradient of the ellipsoid") {
  for (double lat_deg : {-90.0, -63.0, 0.0, 12.0, 45.0, 89.999, 90.0}) {
    const Geodetic at = Geodetic::from_degrees(lat_deg, 138.7);
    const Ellipsoid e;
    const dvec3 p = ecef_from_geodetic(at);
    const dvec3 gradient = glm::normalize(p / dvec3(e.a_m * e.a_m, e.a_m * e.a_m, e.b_m * e.b_m));
    CHECK(glm::length(gradient - geodetic_up_ecef(at.lat_rad, at.lon_rad)) < 1e-14);
  }
}

TEST_CASE("the map direction has the parametric latitude: tan beta = b/a tan lat on the ellipsoid") {
  const Ellipsoid e;
  for (double lat_deg : {-80.0, -10.0, 35.0, 60.0}) {
    const Geodetic at = Geodetic::from_degrees(lat_deg, 25.0);
    const dvec3 d = map_direction_from_ecef(ecef_from_geodetic(at));
    CHECK(std::abs(std::tan(at.lat_rad) * e.b_m / e.a_m - d.z / std::hypot(d.x, d.y)) < 1e-14 / std::cos(at.lat_rad));
    CHECK(std::abs(std::atan2(d.y, d.x) - at.lon_rad) < 1e-15);
  }
}
