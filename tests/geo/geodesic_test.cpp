#include "geo/geodesic.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "oracles/oracle_table.h"

using namespace nepho;
using nepho::test::oracle_table;

namespace {
Geodetic place(const test::OracleRow& row, const std::string& prefix) {
  return Geodetic::from_degrees(row.number(prefix + "lat_deg"), row.number(prefix + "lon_deg"));
}
Geodetic end_place(const test::OracleRow& row, const std::string& suffix) {
  return Geodetic::from_degrees(row.number("lat" + suffix + "_deg"), row.number("lon" + suffix + "_deg"));
}
double apart_m(const Geodetic& a, const Geodetic& b) {
  return glm::length(ecef_from_geodetic(a) - ecef_from_geodetic(b));
}
double angle_apart_deg(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360.0)); }
}  // namespace

TEST_CASE("inverse geodesics agree with the table: 10 um, 1e-9 degrees where the azimuth is well-conditioned") {
  const auto rows = oracle_table("geodesic_inverse");
  REQUIRE(rows.size() >= 160);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const Geodetic from = end_place(row, "1"), to = end_place(row, "2");
    const GeodesicInverse g = geodesic_inverse(from, to);
    CHECK(std::abs(g.distance_m - row.number("s12_m")) < 1e-5);
    CHECK(std::abs(deg_from_rad(g.arc_rad) - row.number("a12_deg")) < 1e-9);
    // The azimuth's own check, good for every category: going there arrives there.
    CHECK(apart_m(geodesic_direct(from, g.azimuth1_rad, g.distance_m).point, to) < 1e-5);
    const std::string& category = row.text("category");
    const bool ill = category == "near_antipodal" || category == "polar" || category == "short";
    if (ill) continue;
    CHECK(angle_apart_deg(deg_from_rad(g.azimuth1_rad), row.number("azi1_deg")) < 1e-9);
    CHECK(angle_apart_deg(deg_from_rad(g.azimuth2_rad), row.number("azi2_deg")) < 1e-9);
  }
}

TEST_CASE("quarter points of a path agree with the table, and near antipodes they lie at quarter distances") {
  for (const auto& row : oracle_table("geodesic_inverse")) {
    CAPTURE(row.id());
    const Geodetic from = end_place(row, "1"), to = end_place(row, "2");
    const GeodesicPath path(from, to);
    const char* names[] = {"q25_", "mid_", "q75_"};
    for (int quarter = 1; quarter <= 3; ++quarter) {
      const double fraction = 0.25 * quarter;
      const Geodetic point = path.at(fraction);
      if (row.text("category") != "near_antipodal") CHECK(apart_m(point, place(row, names[quarter - 1])) < 1e-5);
      CHECK(std::abs(geodesic_inverse(from, point).distance_m - fraction * path.distance_m()) < 1e-5);
      CHECK(std::abs(geodesic_inverse(point, to).distance_m - (1.0 - fraction) * path.distance_m()) < 1e-5);
    }
  }
}

TEST_CASE("direct geodesics agree with the table within 10 um") {
  const auto rows = oracle_table("geodesic_direct");
  REQUIRE(rows.size() >= 100);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const GeodesicEnd end =
        geodesic_direct(end_place(row, "1"), rad_from_deg(row.number("azi1_deg")), row.number("s12_m"));
    CHECK(apart_m(end.point, end_place(row, "2")) < 1e-5);
    if (std::abs(row.number("lat2_deg")) < 89.9)
      CHECK(angle_apart_deg(deg_from_rad(end.azimuth_rad), row.number("azi2_deg")) < 1e-9);
  }
}

TEST_CASE("a path runs from its first to its second end with heights in proportion") {
  const Geodetic from = Geodetic::from_degrees(51.5, -0.1, 100), to = Geodetic::from_degrees(35.7, 139.7, 900);
  const GeodesicPath path(from, to);
  CHECK(apart_m(path.at(0.0), from) < 1e-6);
  CHECK(apart_m(path.at(1.0), to) < 1e-6);
  CHECK(path.at(0.5).height_m == doctest::Approx(500.0));
}

TEST_CASE("a path between coincident places stays there") {
  const Geodetic here = Geodetic::from_degrees(47, 8);
  CHECK(apart_m(GeodesicPath(here, here).at(0.5), here) < 1e-8);
}
