#include "geo/frames.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "oracles/oracle_table.h"

using namespace nepho;
using nepho::test::oracle_table;

TEST_CASE("east, north, up and a target in local ENU agree with the table: 1e-12 and 1 um") {
  const auto rows = oracle_table("enu_frames");
  REQUIRE(rows.size() >= 100);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const Geodetic origin =
        Geodetic::from_degrees(row.number("lat_deg"), row.number("lon_deg"), row.number("height_m"));
    const dmat4 ecef_from_enu = make_ecef_from_enu(origin);
    const char* names[] = {"east", "north", "up"};
    for (int axis = 0; axis < 3; ++axis) {
      const std::string n = names[axis];
      const dvec3 expected(row.number(n + "_x"), row.number(n + "_y"), row.number(n + "_z"));
      CHECK(glm::length(dvec3(ecef_from_enu[axis]) - expected) < 1e-12);
    }
    const dvec3 target = ecef_from_geodetic(Geodetic::from_degrees(
        row.number("target_lat_deg"), row.number("target_lon_deg"), row.number("target_height_m")));
    const dvec3 enu = dvec3(make_enu_from_ecef(origin) * glm::dvec4(target, 1.0));
    const dvec3 expected(row.number("target_e_m"), row.number("target_n_m"), row.number("target_u_m"));
    CHECK(glm::length(enu - expected) < 1e-6);
    CHECK(glm::length(dvec3(ecef_from_enu * glm::dvec4(expected, 1.0)) - target) < 1e-6);
  }
}

TEST_CASE("at 0N 0E, up is ECEF +X, east is +Y, north is +Z") {
  const dmat3 m = make_ecef_from_enu_rotation({});
  CHECK(glm::length(m[0] - dvec3(0, 1, 0)) < 1e-15);
  CHECK(glm::length(m[1] - dvec3(0, 0, 1)) < 1e-15);
  CHECK(glm::length(m[2] - dvec3(1, 0, 0)) < 1e-15);
}

TEST_CASE("camera-relative positions keep a millimetre at the Earth's surface") {
  const dvec3 camera(-3957314.611, 3310254.137, 3737540.043);
  const dvec3 offset(0.001, -123.456, 7.25);
  CHECK(glm::length(dvec3(cam_from_ecef(camera + offset, camera)) - offset) < 1e-5);
}

TEST_CASE("heading turns clockwise from north, pitch rises, roll tips the right side down") {
  const Geodetic at{};  // east +Y, north +Z, up +X
  const CameraAxes level = camera_axes_ecef(at, {});
  CHECK(glm::length(level.forward - dvec3(0, 0, 1)) < 1e-15);
  CHECK(glm::length(level.right - dvec3(0, 1, 0)) < 1e-15);
  CHECK(glm::length(level.up - dvec3(1, 0, 0)) < 1e-15);
  const CameraAxes east = camera_axes_ecef(at, Attitude::from_degrees(90, 0));
  CHECK(glm::length(east.forward - dvec3(0, 1, 0)) < 1e-15);
  CHECK(glm::length(east.right - dvec3(0, 0, -1)) < 1e-15);
  const CameraAxes down = camera_axes_ecef(at, Attitude::from_degrees(0, -90));
  CHECK(glm::length(down.forward - dvec3(-1, 0, 0)) < 1e-15);
  CHECK(glm::length(down.up - dvec3(0, 0, 1)) < 1e-15);  // north is on top of a map
  const CameraAxes rolled = camera_axes_ecef(at, Attitude::from_degrees(0, 0, 90));
  CHECK(glm::length(rolled.right - dvec3(-1, 0, 0)) < 1e-15);
  CHECK(glm::length(rolled.up - dvec3(0, 1, 0)) < 1e-15);
}

TEST_CASE("camera axes are orthonormal with up = right x forward at any attitude") {
  for (double heading : {-200.0, 12.0, 359.0})
    for (double pitch : {-90.0, -30.0, 0.0, 89.0})
      for (double roll : {-170.0, 0.0, 33.0}) {
        const CameraAxes c =
            camera_axes_ecef(Geodetic::from_degrees(-41, 174, 50), Attitude::from_degrees(heading, pitch, roll));
        CHECK(std::abs(glm::dot(c.forward, c.right)) < 1e-15);
        CHECK(std::abs(glm::length(c.forward) - 1.0) < 1e-15);
        CHECK(glm::length(glm::cross(c.right, c.forward) - c.up) < 1e-15);
      }
}

TEST_CASE("a camera that looks towards a target has it straight ahead, from 1 m to 36,000 km") {
  const Geodetic fuji = Geodetic::from_degrees(35.3606, 138.7274, 3700);
  for (const Geodetic& camera :
       {Geodetic::from_degrees(35.47, 138.60, 2500), Geodetic::from_degrees(0, 140.7, 35786e3),
        Geodetic::from_degrees(35.3606, 138.72741, 3700.0), Geodetic::from_degrees(-35.3606, -41.2726, 10.0)}) {
    const auto attitude = heading_pitch_towards(camera, fuji);
    REQUIRE(attitude.has_value());
    CHECK(attitude->roll_rad == 0.0);
    const dvec3 offset = ecef_from_geodetic(fuji) - ecef_from_geodetic(camera);
    CHECK(glm::length(camera_axes_ecef(camera, *attitude).forward - glm::normalize(offset)) < 1e-8);
  }
}

TEST_CASE("towards: straight down has heading 0, and the same place has no direction") {
  const Geodetic ground = Geodetic::from_degrees(10, 20), above = Geodetic::from_degrees(10, 20, 1000);
  const auto down = heading_pitch_towards(above, ground);
  REQUIRE(down.has_value());
  CHECK(down->heading_rad == 0.0);
  CHECK(down->pitch_rad == doctest::Approx(-std::numbers::pi / 2).epsilon(1e-12));
  CHECK_FALSE(heading_pitch_towards(ground, ground).has_value());
}
