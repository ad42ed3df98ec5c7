#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "astro/moonlight.h"
#include "render/frame_setup.h"
#include "render/night_sky_shared.h"

using namespace nepho;

namespace {
const vec3 kSunAt1Au(134e3f, 132e3f, 130e3f);

double luminance(const vec3& c) { return static_cast<double>(0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z); }

/// A camera on the equator where the sun, in the equator's plane, stands at an elevation.
shared::FrameConstants frame_at(double sun_elevation_deg, double height_m, bool has_moon = true) {
  CameraPose pose;
  pose.at = Geodetic::from_degrees(0.0, 0.0, height_m);
  pose.ecef_m = ecef_from_geodetic(pose.at);
  pose.axes = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
  pose.fov_rad = 1.0;
  const double e = rad_from_deg(sun_elevation_deg);
  FrameLight light;
  light.sun_dir_ecef = {std::sin(e), std::cos(e), 0.0};
  light.sun_distance_au = 1.01;
  light.sun_illuminance_at_1au = kSunAt1Au;
  light.has_moon = has_moon;
  light.moon_ecef_m = FrameLight::kMeanMoonDistance_m * dvec3(0.0, 0.0, 1.0);
  light.sun_from_moon_ecef = {0.0, 0.0, -1.0};  // full
  return make_frame_constants(pose, {64, 36}, light, 0.0, 0, 0, glm::vec2(0.0f));
}
}  // namespace

TEST_CASE("frame light: the moon stands where it is from the camera, not from the Earth's centre") {
  const shared::FrameConstants f = frame_at(-30.0, 0.0);
  // 6378 km aside at 384,400 km: 57 arc minutes of parallax.
  CHECK(std::atan2(-static_cast<double>(f.moon_dir.x), static_cast<double>(f.moon_dir.z)) ==
        doctest::Approx(std::atan(6378.137 / 384400.0)).epsilon(1e-5));
  const double distance_m = std::hypot(6378137.0, 384400e3);
  CHECK(static_cast<double>(f.moon_angular_radius_rad) == doctest::Approx(std::asin(1737.4e3 / distance_m)));
}

TEST_CASE("frame light: full moonlight is 1 / 400,000 of sunlight, and is the key light deep at night") {
  const shared::FrameConstants f = frame_at(-30.0, 0.0);
  CHECK(luminance(f.moon_share * kSunAt1Au) / luminance(kSunAt1Au) == doctest::Approx(2.49e-6).epsilon(0.03));
  CHECK(f.key_dir == f.moon_dir);
  CHECK(luminance(f.key_illuminance) == doctest::Approx(luminance(f.moon_share * kSunAt1Au)));
  CHECK(luminance(f.sun_illuminance) == doctest::Approx(luminance(kSunAt1Au) / (1.01 * 1.01)));
  CHECK(f.sun_illuminance_1au == kSunAt1Au);
}

TEST_CASE("frame light: the moon lights the air from a sun of -1 degree down, from above 60 km of -6 degrees") {
  CHECK(frame_at(-0.9, 2.0).light_count == 1);
  CHECK(frame_at(-1.1, 2.0).light_count == 2);
  CHECK(frame_at(40.0, 59e3).light_count == 1);
  CHECK(frame_at(-5.9, 61e3).light_count == 1);
  CHECK(frame_at(-6.1, 61e3).light_count == 2);
  CHECK(frame_at(-30.0, 2.0, false).light_count == 1);
}

TEST_CASE("frame light: the moon is the key light where nothing in sight is sunlit") {
  const auto moon_is_key = [](double elevation_deg, double height_m, bool has_moon = true) {
    const shared::FrameConstants f = frame_at(elevation_deg, height_m, has_moon);
    return f.key_dir != f.sun_dir;
  };
  CHECK_FALSE(moon_is_key(-8.9, 0.0));
  CHECK(moon_is_key(-9.1, 0.0));
  CHECK_FALSE(moon_is_key(-9.1, 10e3));  // the horizon dips by 3.2 degrees
  CHECK(moon_is_key(-12.3, 10e3));
  CHECK_FALSE(moon_is_key(-28.0, 400e3));  // by 19.8
  CHECK(moon_is_key(-29.0, 400e3));
  CHECK_FALSE(moon_is_key(-30.0, 0.0, false));
  const shared::FrameConstants none = frame_at(-30.0, 0.0, false);
  CHECK(none.moon_share == vec3(0.0f));
  CHECK(none.key_illuminance == none.sun_illuminance);
}

TEST_CASE(
    "frame light: the moon's light grows from nothing within 4 degrees, as the air's second light and as the key") {
  const double full = luminance(frame_at(-40.0, 0.0).moon_share);
  CHECK(luminance(frame_at(-1.0001, 0.0).moon_share) < 1e-6 * full);
  CHECK(luminance(frame_at(-3.0, 0.0).moon_share) == doctest::Approx(0.5 * full).epsilon(1e-3));
  CHECK(luminance(frame_at(-5.001, 0.0).moon_share) == doctest::Approx(full));
  CHECK(luminance(frame_at(-8.0, 400e3).moon_share) == doctest::Approx(0.5 * full).epsilon(0.02));
  const double key = luminance(frame_at(-40.0, 0.0).key_illuminance);
  CHECK(luminance(frame_at(-9.0001, 0.0).key_illuminance) < 1e-6 * key);
  CHECK(luminance(frame_at(-11.0, 0.0).key_illuminance) == doctest::Approx(0.5 * key).epsilon(1e-3));
  CHECK(luminance(frame_at(-13.001, 0.0).key_illuminance) == doctest::Approx(key));
}

TEST_CASE("night sky: pixels' solid angles sum to the picture's") {
  const shared::FrameConstants f = frame_at(-30.0, 0.0);
  double sum = 0.0;
  for (uint32_t y = 0; y < f.size.y; ++y)
    for (uint32_t x = 0; x < f.size.x; ++x)
      sum += static_cast<double>(shared::pixel_solid_angle_sr(f, glm::vec2(x, y) + 0.5f));
  // A rectangular pyramid of half angles with tangents a, b: 4 atan(a b / sqrt(1 + a^2 + b^2)).
  const double b = std::tan(0.5), a = b * 64.0 / 36.0;
  CHECK(sum == doctest::Approx(4.0 * std::atan(a * b / std::sqrt(1.0 + a * a + b * b))).epsilon(1e-4));
}

TEST_CASE("night sky: pixel_from_direction undoes pixel_direction, and a star's weights sum to 1") {
  shared::FrameConstants f = frame_at(-30.0, 0.0);
  f.jitter_px = glm::vec2(0.2f, -0.4f);
  for (const glm::vec2 p : {glm::vec2(0.5f), glm::vec2(33.1f, 17.9f), glm::vec2(63.0f, 1.25f)}) {
    glm::vec2 back(0.0f);
    CHECK(shared::pixel_from_direction(f, shared::pixel_direction(f, p), back));
    CHECK(glm::length(back - p) < 1e-3f);
    CHECK_FALSE(shared::pixel_from_direction(f, -shared::pixel_direction(f, p), back));
  }
  for (const float at : {-0.5f, -0.2f, 0.0f, 0.37f, 0.5f}) {
    float sum = 0.0f, centre = 0.0f;
    for (int i = -2; i <= 2; ++i) {
      sum += shared::star_weight(i, at);
      centre += static_cast<float>(i) * shared::star_weight(i, at);
    }
    CHECK(sum == doctest::Approx(1.0f));
    CHECK(std::abs(centre - at) < 0.005f);
  }
}

TEST_CASE("night sky: the moon's law of reflection is even at full moon, and follows Lambert's cosine at 90 degrees") {
  CHECK(shared::lunar_lambert_share(0.0f) == 1.0f);
  for (const float mu : {1.0f, 0.5f, 0.05f}) CHECK(shared::lunar_shading(mu, mu, 1.0f) == doctest::Approx(1.0f));
  CHECK(shared::lunar_shading(-0.1f, 0.5f, 0.3f) == 0.0f);
  CHECK(shared::lunar_shading(0.25f, 0.9f, 0.0f) == doctest::Approx(0.25f));
  // McEwen 1991: 1 - 0.019 a + 2.42e-4 a^2 - 1.46e-6 a^3 at 60 degrees.
  CHECK(shared::lunar_lambert_share(1.0471976f) == doctest::Approx(0.41584f).epsilon(1e-4));
}

TEST_CASE("night sky: light of airglow on the ground is van Rhijn's law integrated over the sky") {
  double sum = 0.0;
  const double ratio = 6371.0 / 6462.0;
  for (int i = 0; i < 20000; ++i) {
    const double mu = (i + 0.5) / 20000.0;
    sum += 2.0 * static_cast<double>(shared::kPi) * mu / std::sqrt(1.0 - ratio * ratio * (1.0 - mu * mu)) / 20000.0;
  }
  CHECK(static_cast<double>(shared::airglow_illuminance_per_luminance()) == doctest::Approx(sum).epsilon(1e-3));
}
