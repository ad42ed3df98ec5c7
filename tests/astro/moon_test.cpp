#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "astro/moon_orientation.h"
#include "astro/moonlight.h"
#include "astro/sky_bodies.h"
#include "astro/spectral_color.h"

using namespace nepho;

namespace {
constexpr double kMeanDistance_m = 384400e3;

double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// Selenographic latitude and longitude of a direction, degrees.
struct Spot {
  double lat_deg, lon_deg;
};
Spot spot_of(const dvec3& body) { return {deg_from_rad(std::asin(body.z)), deg_from_rad(std::atan2(body.y, body.x))}; }
// The example's moment is 1992-04-12, 0h dynamical time: with TT - UT = 0 that is what the text says.
SkyBodies meeus_example() { return sky_bodies_at(parse_utc("1992-04-12T00:00:00Z"), 0.0); }
constexpr double kMeeusCenturies = -0.077221081451;
}  // namespace

TEST_CASE("moon: Meeus example 53.a, librations of 1992-04-12") {
  const SkyBodies sky = meeus_example();
  const Spot total = spot_of(sky.moon.body_from_ecef * -sky.moon.dir_ecef);
  CHECK(std::abs(total.lon_deg - -1.23) < 0.006);  // two decimals are printed
  CHECK(std::abs(total.lat_deg - 4.20) < 0.006);
  const PhysicalLibration physical = moon_physical_libration(kMeeusCenturies);
  CHECK(std::abs(deg_from_rad(physical.inclination) - -0.01042) < 2e-5);
  CHECK(std::abs(deg_from_rad(physical.node) - -0.01574) < 2e-5);
  CHECK(std::abs(deg_from_rad(physical.longitude) - 0.02673) < 2e-5);
  // Without the physical part: the optical librations alone.
  const dmat3 undo = moon_body_from_mean_ecliptic(kMeeusCenturies, physical);
  const dmat3 optical = moon_body_from_mean_ecliptic(kMeeusCenturies, {});
  const Spot mean = spot_of(optical * glm::transpose(undo) * (sky.moon.body_from_ecef * -sky.moon.dir_ecef));
  CHECK(std::abs(mean.lon_deg - -1.206) < 0.002);
  CHECK(std::abs(mean.lat_deg - 4.194) < 0.002);
}

TEST_CASE("moon: Meeus example 53.a, the axis stands at position angle 15.08 degrees") {
  const SkyBodies sky = meeus_example();
  const dvec3 pole = glm::transpose(sky.moon.body_from_ecef)[2];
  const dvec3 east = glm::normalize(glm::cross(dvec3(0, 0, 1), sky.moon.dir_ecef));
  const dvec3 north = glm::cross(sky.moon.dir_ecef, east);
  CHECK(std::abs(deg_from_rad(std::atan2(glm::dot(pole, east), glm::dot(pole, north))) - 15.08) < 0.01);
}

TEST_CASE("moon: its axes are a rotation, librations stay below 8.2 and 6.9 degrees and average to nothing") {
  double mean_lon = 0.0, mean_lat = 0.0, most_lon = 0.0, most_lat = 0.0;
  const int days = 6798;  // a turn of the node, 18.6 years
  for (int i = 0; i < days; i += 2) {
    const SkyBodies sky = sky_bodies_at(parse_utc("2000-01-01").plus_seconds(86400.0 * i));
    const dmat3& m = sky.moon.body_from_ecef;
    if (i % 500 == 0) {
      CHECK(std::abs(glm::determinant(m) - 1.0) < 1e-12);
      CHECK(glm::length(m * glm::transpose(m) * dvec3(1, 2, 3) - dvec3(1, 2, 3)) < 1e-12);
    }
    const Spot s = spot_of(m * -sky.moon.dir_ecef);
    mean_lon += 2.0 * s.lon_deg / days;
    mean_lat += 2.0 * s.lat_deg / days;
    most_lon = std::max(most_lon, std::abs(s.lon_deg));
    most_lat = std::max(most_lat, std::abs(s.lat_deg));
  }
  CHECK(std::abs(mean_lon) < 0.05);
  CHECK(std::abs(mean_lat) < 0.05);
  CHECK(most_lon > 7.5);
  CHECK(most_lon < 8.2);
  CHECK(most_lat > 6.5);
  CHECK(most_lat < 6.9);
}

TEST_CASE("moon: the sun stands within 1.65 degrees of its equator, and over its near side at full moon") {
  for (int i = 0; i < 700; i += 5) {
    const SkyBodies sky = sky_bodies_at(parse_utc("2026-01-01").plus_seconds(86400.0 * i));
    const Spot sun = spot_of(sky.moon.body_from_ecef * sky.moon.sun_from_moon_ecef);
    CHECK(std::abs(sun.lat_deg) < 1.65);  // the tilt, 1.54, and the physical librations
    CHECK(std::abs(glm::length(sky.moon.sun_from_moon_ecef) - 1.0) < 1e-12);
    CHECK(std::acos(glm::dot(sky.moon.sun_from_moon_ecef, -sky.moon.dir_ecef)) ==
          doctest::Approx(sky.moon.phase_angle_rad).epsilon(1e-6));
    CHECK(std::abs(sky.moon.sun_distance_au - sky.sun.distance_au) < 0.0028);  // the moon's distance, au
  }
}

TEST_CASE("moonlight: full moon is 1 / 400,000 of the sun, 0.25 to 0.33 lux; a quarter moon a tenth of it") {
  const double full = moon_sun_illuminance_ratio(0.0, kMeanDistance_m, 1.0);
  CHECK(1.0 / full == doctest::Approx(402e3).epsilon(0.005));  // 14.01 magnitudes
  const double sun_lux = 128e3;
  CHECK(full * sun_lux > 0.25);
  CHECK(full * sun_lux < 0.33);
  const double quarter = moon_sun_illuminance_ratio(rad_from_deg(90.0), kMeanDistance_m, 1.0) / full;
  CHECK(quarter > 0.08);
  CHECK(quarter < 0.10);
  // 0.026 * 120 + 4e-9 * 120^4 magnitudes.
  CHECK(-2.5 * std::log10(moon_sun_illuminance_ratio(rad_from_deg(120.0), kMeanDistance_m, 1.0) / full) ==
        doctest::Approx(3.9494).epsilon(1e-4));
}

TEST_CASE("moonlight: inverse squares of both distances, falls with phase, no step where the formula ends") {
  const double full = moon_sun_illuminance_ratio(0.3, kMeanDistance_m, 1.0);
  CHECK(moon_sun_illuminance_ratio(0.3, 0.5 * kMeanDistance_m, 1.0) == doctest::Approx(4.0 * full));
  CHECK(moon_sun_illuminance_ratio(0.3, kMeanDistance_m, 2.0) == doctest::Approx(0.25 * full));
  CHECK(moon_sun_illuminance_ratio(-0.3, kMeanDistance_m, 1.0) == full);
  double before = 1.0;
  for (double a = 0.0; a <= 180.0; a += 0.25) {
    const double now = moon_sun_illuminance_ratio(rad_from_deg(a), kMeanDistance_m, 1.0);
    CHECK(now >= 0.0);
    CHECK(now < before);
    before = now;
  }
  const double below = moon_sun_illuminance_ratio(rad_from_deg(149.999), kMeanDistance_m, 1.0);
  const double above = moon_sun_illuminance_ratio(rad_from_deg(150.001), kMeanDistance_m, 1.0);
  CHECK(above == doctest::Approx(below).epsilon(1e-3));
  CHECK(before == 0.0);  // new moon
}

TEST_CASE("moonlight: as luminous as its white, redder than the sun") {
  const dvec3 moon = moonlight_color(), earth = earthshine_color();
  const dvec3 sun = rec709_from_planck(5778.0);
  CHECK(luminance(moon * sun) == doctest::Approx(1.0).epsilon(1e-4));
  CHECK(luminance(earth * sun) == doctest::Approx(1.0).epsilon(1e-4));
  CHECK(moon.x > 1.05);
  CHECK(moon.z < 0.85);
  CHECK(moon.z > 0.70);  // B alone, 440 nm, loses 0.27 magnitudes: 0.78
  CHECK(earth.z > moon.z);
  CHECK(earth.x < moon.x);
}

TEST_CASE("earthshine: 10 to 14 lux on the new moon, half an Earth a third of that, nothing at full moon") {
  const double sun_lux = 128e3;
  const double full_earth = earthshine_illuminance_ratio(rad_from_deg(180.0), kMeanDistance_m, 1.0) * sun_lux;
  CHECK(full_earth > 10.0);
  CHECK(full_earth < 14.0);
  const double half = earthshine_illuminance_ratio(rad_from_deg(90.0), kMeanDistance_m, 1.0) * sun_lux;
  CHECK(half / full_earth == doctest::Approx(0.31831).epsilon(1e-4));  // Lambert: 1 / pi
  CHECK(std::abs(earthshine_illuminance_ratio(0.0, kMeanDistance_m, 1.0)) < 1e-12);
}

TEST_CASE("earthshine: a Lambert sphere scatters all light that it gets") {
  // Bond albedo = geometric albedo (2/3) times 2 * integral of phase * sin: 1.5 for Lambert's law.
  double q = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double a = (i + 0.5) * std::numbers::pi / 1000.0;
    q += 2.0 * lambert_phase(a) * std::sin(a) * std::numbers::pi / 1000.0;
  }
  CHECK(q == doctest::Approx(1.5).epsilon(1e-4));
}
