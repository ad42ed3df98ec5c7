#include "astro/sky_bodies.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "astro/time_scales.h"
#include "oracles/oracle_table.h"

using namespace nepho;
using nepho::test::oracle_table;

namespace {
constexpr double kArcSecond = std::numbers::pi / 180.0 / 3600.0;

// Table directions have 15 digits: their lengths are 1 to 1e-15.
double apart_arcsec(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) / kArcSecond;
}
double degrees_apart(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360.0)); }
dvec3 direction(const test::OracleRow& row, const std::string& body) {
  return {row.number(body + "_x"), row.number(body + "_y"), row.number(body + "_z")};
}
int year_of(const test::OracleRow& row) { return std::stoi(row.text("utc").substr(0, 4)); }
}  // namespace

TEST_CASE("sun and moon agree with the independent ephemeris given its TT: 5 and 20 arc seconds, 1950..2100") {
  const auto rows = oracle_table("ephemeris");
  REQUIRE(rows.size() >= 160);
  double worst_sun = 0.0, worst_moon = 0.0, worst_gast = 0.0;
  for (const auto& row : rows) {
    CAPTURE(row.text("utc"));
    const UtcInstant utc = parse_utc(row.text("utc"));
    const SkyBodies sky = sky_bodies_at(utc, row.number("tt_minus_ut_s"));
    const double sun = apart_arcsec(sky.sun.dir_ecef, direction(row, "sun"));
    const double moon = apart_arcsec(sky.moon.dir_ecef, direction(row, "moon"));
    CHECK(sun < 5.0);
    CHECK(moon < 20.0);
    const double gast = degrees_apart(deg_from_rad(sky.gast_rad), row.number("gast_deg")) * 3600.0;
    CHECK(gast < 0.5);
    CHECK(std::abs(sky.sun.distance_au / row.number("sun_dist_au") - 1.0) < 1e-4);
    CHECK(std::abs(sky.moon.distance_m / 1e3 / row.number("moon_dist_km") - 1.0) < 2e-4);
    CHECK(std::abs(deg_from_rad(sky.sun.angular_radius_rad) / row.number("sun_ang_radius_deg") - 1.0) < 1e-4);
    CHECK(std::abs(deg_from_rad(sky.moon.angular_radius_rad) / row.number("moon_ang_radius_deg") - 1.0) < 2e-4);
    CHECK(std::abs(sky.moon.illuminated_fraction - row.number("moon_illuminated_fraction")) < 1e-3);
    CHECK(std::abs(deg_from_rad(sky.moon.phase_angle_rad) - row.number("moon_phase_angle_deg")) < 0.01);
    CHECK(degrees_apart(deg_from_rad(sky.moon.ecliptic_elongation_rad), row.number("moon_ecl_elongation_deg")) < 0.01);
    CHECK(std::abs(utc.julian_date() - row.number("jd_ut")) < 1e-8);
    worst_sun = std::max(worst_sun, sun);
    worst_moon = std::max(worst_moon, moon);
    worst_gast = std::max(worst_gast, gast);
  }
  MESSAGE("worst: sun " << worst_sun << ", moon " << worst_moon << ", GAST " << worst_gast << " arc seconds");
}

TEST_CASE("with our own TT: sun 5, moon 20 arc seconds before 2026; 10 and 100 for all years") {
  double worst_sun = 0.0, worst_moon = 0.0;
  for (const auto& row : oracle_table("ephemeris")) {
    CAPTURE(row.text("utc"));
    const SkyBodies sky = sky_bodies_at(parse_utc(row.text("utc")));
    const bool early = year_of(row) < 2026;
    const double sun = apart_arcsec(sky.sun.dir_ecef, direction(row, "sun"));
    const double moon = apart_arcsec(sky.moon.dir_ecef, direction(row, "moon"));
    CHECK(sun < (early ? 5.0 : 10.0));
    CHECK(moon < (early ? 20.0 : 100.0));
    worst_sun = std::max(worst_sun, sun);
    worst_moon = std::max(worst_moon, moon);
  }
  MESSAGE("worst: sun " << worst_sun << ", moon " << worst_moon << " arc seconds");
}

TEST_CASE("topocentric elevation and azimuth agree within 15 arc seconds, parallax included") {
  for (const auto& row : oracle_table("ephemeris")) {
    CAPTURE(row.text("utc"));
    const SkyBodies sky = sky_bodies_at(parse_utc(row.text("utc")), row.number("tt_minus_ut_s"));
    const Geodetic observer =
        Geodetic::from_degrees(row.number("obs_lat_deg"), row.number("obs_lon_deg"), row.number("obs_height_m"));
    const Horizontal sun = horizontal_from_ecef(observer, sky.sun.dir_ecef, sky.sun.distance_au * kAstronomicalUnit_m);
    const Horizontal moon = horizontal_from_ecef(observer, sky.moon.dir_ecef, sky.moon.distance_m);
    CHECK(std::abs(deg_from_rad(sun.elevation_rad) - row.number("sun_elev_deg")) * 3600.0 < 15.0);
    CHECK(degrees_apart(deg_from_rad(sun.azimuth_rad), row.number("sun_az_deg")) * std::cos(sun.elevation_rad) *
              3600.0 <
          15.0);
    CHECK(std::abs(deg_from_rad(moon.elevation_rad) - row.number("moon_topo_elev_deg")) * 3600.0 < 20.0);
    CHECK(degrees_apart(deg_from_rad(moon.azimuth_rad), row.number("moon_topo_az_deg")) * std::cos(moon.elevation_rad) *
              3600.0 <
          20.0);
    CHECK(std::abs(moon.distance_m / 1e3 / row.number("moon_topo_dist_km") - 1.0) < 2e-4);
  }
}

TEST_CASE("TT - UT is 64.184 s in 2000, 69.184 s in 2026, and jumps by less than 0.2 s where models meet") {
  CHECK(tt_minus_ut_s(parse_utc("2000-06-01")) == doctest::Approx(64.184).epsilon(1e-12));
  CHECK(tt_minus_ut_s(parse_utc("2017-01-01")) == doctest::Approx(69.184).epsilon(1e-12));
  CHECK(tt_minus_ut_s(parse_utc("2016-12-31T23:59:59Z")) == doctest::Approx(68.184).epsilon(1e-12));
  CHECK(tt_minus_ut_s(parse_utc("2026-06-20")) == doctest::Approx(69.184).epsilon(1e-12));
  for (const int year : {1920, 1941, 1961, 1972, 2027, 2050, 2057}) {
    CAPTURE(year);
    const UtcInstant joint{day_from_calendar({year, 1, 1}), 0.0};
    CHECK(std::abs(tt_minus_ut_s(joint.plus_seconds(86400.0)) - tt_minus_ut_s(joint.plus_seconds(-86400.0))) < 0.2);
  }
  // Espenak & Meeus 2006, tables of historical values: 1900 -2.8, 1950 29.1, 2100 203 s.
  CHECK(tt_minus_ut_s(parse_utc("1900-01-01")) == doctest::Approx(-2.79).epsilon(0.02));
  CHECK(tt_minus_ut_s(parse_utc("1950-01-01")) == doctest::Approx(29.07).epsilon(0.01));
  CHECK(tt_minus_ut_s(parse_utc("2100-01-01")) == doctest::Approx(202.7).epsilon(0.01));
}

TEST_CASE("ecef_from_icrs is a rotation by the sidereal time about nearly the same pole") {
  const SkyBodies sky = sky_bodies_at(parse_utc("2000-01-01T12:00:00Z"));
  const dmat3& m = sky.ecef_from_icrs;
  CHECK(std::abs(glm::determinant(m) - 1.0) < 1e-14);
  const dmat3 product = m * glm::transpose(m);
  for (int i = 0; i < 3; ++i) CHECK(glm::length(product[i] - dmat3(1.0)[i]) < 1e-14);
  // At J2000 precession is nil and nutation 17 arc seconds at most.
  CHECK(apart_arcsec(m * dvec3(0, 0, 1), dvec3(0, 0, 1)) < 20.0);
  const dvec3 equinox = m * dvec3(1, 0, 0);
  CHECK(degrees_apart(deg_from_rad(std::atan2(equinox.y, equinox.x)), -deg_from_rad(sky.gast_rad)) < 0.01);
  CHECK(deg_from_rad(sky.gast_rad) == doctest::Approx(280.4618).epsilon(1e-4));  // GMST at J2000.0, less 13 s nutation
}

TEST_CASE("at an equinox noon at Greenwich the sun stands over the equator, near the meridian") {
  const SkyBodies sky = sky_bodies_at(parse_utc("2024-03-20T12:07:00Z"));  // equinox 03:06, equation of time -7.4 min
  CHECK(std::abs(std::asin(sky.sun.dir_ecef.z)) < rad_from_deg(0.2));
  CHECK(std::abs(std::atan2(sky.sun.dir_ecef.y, sky.sun.dir_ecef.x)) < rad_from_deg(0.2));
  const Horizontal there = horizontal_from_ecef(Geodetic::from_degrees(0, 0), sky.sun.dir_ecef, kAstronomicalUnit_m);
  CHECK(deg_from_rad(there.elevation_rad) > 89.7);
}

TEST_CASE("the total eclipse of 2024-04-08 18:18 UTC: the moon covers the sun as seen from Durango") {
  const SkyBodies sky = sky_bodies_at(parse_utc("2024-04-08T18:18:00Z"));
  const Geodetic durango = Geodetic::from_degrees(24.03, -104.67, 1880);  // in totality 18:12..18:16
  const SkyBodies then = sky_bodies_at(parse_utc("2024-04-08T18:14:00Z"));
  const dvec3 p = ecef_from_geodetic(durango);
  const dvec3 sun = then.sun.dir_ecef * (then.sun.distance_au * kAstronomicalUnit_m) - p;
  const dvec3 moon = then.moon.dir_ecef * then.moon.distance_m - p;
  CHECK(apart_arcsec(sun, moon) < 90.0);
  CHECK(std::asin(kMoonRadius_m / glm::length(moon)) > std::asin(kSunRadius_m / glm::length(sun)));
  CHECK(sky.moon.illuminated_fraction < 1e-3);
}
