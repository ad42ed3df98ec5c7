#include "geo/planet_view.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <random>

#include "geo/frames.h"

using namespace nepho;

namespace {

struct Random {
  std::mt19937_64 engine{11};
  double operator()() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  Geodetic place(double height_m) {
    return {std::asin(2.0 * (*this)() - 1.0), (2.0 * (*this)() - 1.0) * std::numbers::pi, height_m};
  }
  dvec3 direction() {
    const double z = 2.0 * (*this)() - 1.0, angle = 2.0 * std::numbers::pi * (*this)();
    return {std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z};
  }
};

// A place at `height_m` about `distance_m` from the camera, but never further than the other side of the Earth.
Geodetic place_near(Random& random, const Geodetic& camera, double distance_m, double height_m) {
  const double angle = std::min(distance_m / 6.4e6, 3.1), azimuth = 2.0 * std::numbers::pi * random();
  const dmat3 enu = make_ecef_from_enu_rotation(camera);
  const dvec3 dir =
      std::cos(angle) * enu[2] + std::sin(angle) * (std::sin(azimuth) * enu[0] + std::cos(azimuth) * enu[1]);
  Geodetic place = geodetic_from_ecef(dir * 6.4e6);
  place.height_m = height_m;
  return place;
}

// Roots of the ray against the scaled sphere, in double without cancellation; false when it misses. `margin_m` is how
// far inside the shell the ray passes.
bool shell_in_double(const dvec3& camera_ecef, const dvec3& dir, double shell_m, const Ellipsoid& e, glm::dvec2& t,
                     double& margin_m) {
  const dvec3 q(camera_ecef.x, camera_ecef.y, camera_ecef.z * e.a_over_b());
  const dvec3 d(dir.x, dir.y, dir.z * e.a_over_b());
  const double a = glm::dot(d, d), b = glm::dot(q, d), radius = e.a_m + shell_m, length = glm::length(q);
  const double nearest = glm::length(q - d * (b / a));
  margin_m = radius - nearest;
  if (margin_m < 0.0) return false;
  const double root = std::sqrt(a * (radius - nearest) * (radius + nearest));
  const double w = b > 0.0 ? -(b + root) : root - b;
  t = {w / a, w != 0.0 ? (length - radius) * (length + radius) / w : w / a};
  if (t.x > t.y) std::swap(t.x, t.y);
  return true;
}

}  // namespace

TEST_CASE("geodetic_height: 1e-7 of the distance plus the formula's own error, 1 m at most near the Earth") {
  Random random;
  for (const double camera_height_m : {2.0, 1000.0, 1e4, 1e5, 4e5, 3e6, 35786e3, 4e7})
    for (int i = 0; i < 3000; ++i) {
      const Geodetic camera = random.place(camera_height_m);
      const dvec3 camera_ecef = ecef_from_geodetic(camera);
      const shared::PlanetView view = make_planet_view(camera_ecef);
      const double wanted_m = std::pow(10.0, 7.7 * random());
      const Geodetic target = place_near(random, camera, wanted_m, -500.0 + 20500.0 * random());
      const vec3 point_cam = cam_from_ecef(ecef_from_geodetic(target), camera_ecef);
      // The height of the point as rounded to float: the caller's rounding is not this function's.
      const double truth_m = geodetic_from_ecef(camera_ecef + dvec3(point_cam)).height_m;
      const double distance_m = glm::length(point_cam);
      // The first camera-relative term is |q0|^2 - a^2 in float: 6e-8 of the camera's height, at most.
      const double near_m = 1e-3 + 6e-8 * camera_height_m + 4e-7 * distance_m;
      const double far_m = camera_height_m > 1e7 ? 4.0 : 1.6;
      CAPTURE(camera_height_m);
      CAPTURE(distance_m);
      REQUIRE(std::abs(double(shared::geodetic_height(view, point_cam)) - truth_m) < std::min(near_m + 1e-3, far_m));
    }
}

TEST_CASE("geodetic_height within 1 km of a camera on the ground is good to 3 mm, within 100 m to 0.3 mm") {
  Random random;
  double worst_1km = 0.0, worst_100m = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const dvec3 camera_ecef = ecef_from_geodetic(random.place(2.0));
    const shared::PlanetView view = make_planet_view(camera_ecef);
    const vec3 point_cam(random.direction() * std::pow(10.0, 3.0 * random()));
    const double error = std::abs(double(shared::geodetic_height(view, point_cam)) -
                                  geodetic_from_ecef(camera_ecef + dvec3(point_cam)).height_m);
    worst_1km = std::max(worst_1km, error);
    if (glm::length(point_cam) < 100.0f) worst_100m = std::max(worst_100m, error);
  }
  CHECK(worst_1km < 3e-3);
  CHECK(worst_100m < 3e-4);
}

TEST_CASE("the height formula itself is off by 0.1 mm at 10 km, 9 mm at 100 km and 13 cm at 400 km at most") {
  // The same formula in double: (|q| - a) |q| / |S q|.
  Random random;
  const Ellipsoid e;
  for (const auto& [height_m, limit_m] : {std::pair{10e3, 1e-4}, std::pair{100e3, 9e-3}, std::pair{400e3, 0.14}})
    for (int i = 0; i < 2000; ++i) {
      const dvec3 p = ecef_from_geodetic(random.place(height_m));
      const dvec3 q(p.x, p.y, p.z * e.a_over_b()), sq(q.x, q.y, q.z * e.a_over_b());
      const double h = (glm::length(q) - e.a_m) * glm::length(q) / glm::length(sq);
      REQUIRE(std::abs(h - height_m) < limit_m);
    }
}

TEST_CASE("planet_q from any camera is good to 1.2 m near the Earth: the camera's lost digits are added back") {
  Random random;
  for (const double camera_height_m : {2.0, 1e5, 1e7, 35786e3})
    for (int i = 0; i < 5000; ++i) {
      const dvec3 camera_ecef = ecef_from_geodetic(random.place(camera_height_m));
      const shared::PlanetView view = make_planet_view(camera_ecef);
      const dvec3 target = ecef_from_geodetic(random.place(20e3 * random()));
      const vec3 point_cam = cam_from_ecef(target, camera_ecef);
      const dvec3 p = camera_ecef + dvec3(point_cam);
      const dvec3 q(p.x, p.y, p.z * Ellipsoid().a_over_b());
      // From space the far side of the Earth cancels less: one more rounding at 3e7 m.
      REQUIRE(glm::length(dvec3(shared::planet_q(view, point_cam)) - q) < (camera_height_m > 5e6 ? 3.2 : 1.2));
    }
}

TEST_CASE("geodetic_up is within 2e-5 rad of the normal below 10 km, 3e-4 below 400 km") {
  Random random;
  for (const auto& [height_m, limit] : {std::pair{0.0, 1e-6}, std::pair{10e3, 2e-5}, std::pair{400e3, 3e-4}})
    for (int i = 0; i < 2000; ++i) {
      const Geodetic at = random.place(height_m), camera = random.place(35786e3 * random());
      const dvec3 camera_ecef = ecef_from_geodetic(camera);
      const vec3 up =
          shared::geodetic_up(make_planet_view(camera_ecef), cam_from_ecef(ecef_from_geodetic(at), camera_ecef));
      REQUIRE(glm::length(dvec3(up) - geodetic_up_ecef(at.lat_rad, at.lon_rad)) < limit);
    }
}

TEST_CASE("intersect_shell finds the double closed form's hits from 2 m to 40,000 km") {
  Random random;
  const Ellipsoid e;
  for (const double camera_height_m : {2.0, 1499.0, 1e4, 1e5, 4e5, 9e5, 3e6, 35786e3, 4e7})
    for (const double shell_m : {0.0, 1500.0, 12e3, 60e3})
      for (int i = 0; i < 2000; ++i) {
        CAPTURE(camera_height_m);
        CAPTURE(shell_m);
        const dvec3 camera_ecef = ecef_from_geodetic(random.place(camera_height_m));
        const shared::PlanetView view = make_planet_view(camera_ecef);
        dvec3 aim = random.direction();
        if (camera_height_m > 3e5) aim = glm::normalize(aim * (6.6e6 * std::cbrt(random())) - camera_ecef);
        const vec3 dir(aim);
        shared::vec2 t;
        glm::dvec2 truth(0.0);
        double margin_m = 0.0;
        const bool hit = shared::intersect_shell(view, dir, static_cast<float>(shell_m), t);
        const bool truly = shell_in_double(camera_ecef, dvec3(dir), shell_m, e, truth, margin_m);
        // A grazing ray may go either way where it passes within the rounding of camera and direction.
        const double graze_m = 1.0 + 3e-7 * camera_height_m;
        if (hit != truly) REQUIRE(std::abs(margin_m) < graze_m);
        if (!hit || !truly) continue;
        for (int k = 0; k < 2; ++k) {
          if (truth[k] < 0.0) continue;
          // Along the ray an error of 1 m in height grows as 1 / sin(incidence); incidence ~ sqrt(2 margin / R).
          const double height_error_m = 4.0 + 3e-7 * camera_height_m;
          const double sine = std::sqrt(std::max(2.0 * margin_m - height_error_m, height_error_m) / e.a_m);
          REQUIRE(std::abs(double(t[k]) - truth[k]) < height_error_m / std::min(sine, 1.0));
        }
      }
}

TEST_CASE("intersect_shell near the camera is relative: a base 1 m overhead is hit to 1 mm") {
  const Geodetic camera = Geodetic::from_degrees(35, 138, 1499.0);
  const dvec3 camera_ecef = ecef_from_geodetic(camera);
  const shared::PlanetView view = make_planet_view(camera_ecef);
  const vec3 up(geodetic_up_ecef(camera.lat_rad, camera.lon_rad));
  for (const double shell_m : {1500.0, 1510.0, 3000.0}) {
    // Scaled height of the geodetic shell overhead, which is what intersect_shell takes.
    const dvec3 q(camera_ecef.x, camera_ecef.y, camera_ecef.z * Ellipsoid().a_over_b());
    const double scaled_m = double(shared::scaled_height_from_geodetic(view, vec3(q), float(shell_m)));
    shared::vec2 t;
    REQUIRE(shared::intersect_shell(view, up, float(scaled_m), t));
    CHECK(t.x < 0.0f);
    CHECK(std::abs(double(t.y) - (shell_m - 1499.0)) < 1e-3 + 1e-6 * (shell_m - 1499.0));
  }
}

TEST_CASE("intersect_shell from inside gives one root ahead, from below none behind a lower shell, from above two") {
  const Geodetic camera = Geodetic::from_degrees(-20, 30, 5000.0);
  const shared::PlanetView view = make_planet_view(ecef_from_geodetic(camera));
  const dvec3 up = geodetic_up_ecef(camera.lat_rad, camera.lon_rad);
  shared::vec2 t;
  REQUIRE(shared::intersect_shell(view, vec3(up), 8000.0f, t));
  CHECK((t.x < 0.0f && t.y > 0.0f));
  REQUIRE(shared::intersect_shell(view, vec3(-up), 1000.0f, t));
  CHECK((t.x > 0.0f && t.y > 1.2e7f));
  REQUIRE(shared::intersect_shell(view, vec3(up), 1000.0f, t));
  CHECK(t.y < 0.0f);
  const dvec3 east = make_ecef_from_enu_rotation(camera)[0];
  CHECK_FALSE(shared::intersect_shell(view, vec3(east), 1000.0f, t));
}

TEST_CASE("on a sphere heights are exact: scaled space is space") {
  const Ellipsoid sphere = Ellipsoid::sphere(6360e3);
  const dvec3 camera(0, 0, 6360e3 + 100.0);
  const shared::PlanetView view = make_planet_view(camera, sphere);
  CHECK(view.camera_height_m == doctest::Approx(100.0f));
  CHECK(view.stretch == 0.0f);
  CHECK(std::abs(shared::geodetic_height(view, vec3(300, 400, 50)) -
                 float(glm::length(camera + dvec3(300, 400, 50)) - 6360e3)) < 1e-4f);
}
