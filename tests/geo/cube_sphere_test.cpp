#include "geo/cube_sphere.h"

#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

using namespace nepho;
using glm::dvec2;
using glm::vec2;

namespace {
dvec3 random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(dvec3(normal(random), normal(random), normal(random)));
}
}  // namespace

TEST_CASE("face centres and orientation are those of Vulkan's cube maps") {
  // Vulkan 1.3, table 'Cube map face and coordinate selection': direction, face, and the ECEF axes of +u and +v.
  const struct {
    dvec3 dir, u_axis, v_axis;
  } faces[] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
               {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
               {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};
  for (uint32_t f = 0; f < 6; ++f) {
    CAPTURE(f);
    const CubePointD centre = cube_from_direction(faces[f].dir);
    CHECK(centre.face == f);
    CHECK(centre.uv == dvec2(0.5));
    const CubePointD right = cube_from_direction(faces[f].dir + 0.5 * faces[f].u_axis + 0.25 * faces[f].v_axis);
    CHECK(right.face == f);
    CHECK(glm::length(right.uv - dvec2(0.75, 0.625)) < 1e-15);
    // Not mirrored as seen from outside: u right, v down.
    CHECK(glm::dot(glm::cross(faces[f].u_axis, faces[f].v_axis), faces[f].dir) == -1.0);
  }
}

TEST_CASE("direction to cube and back: 1e-12 in double, 2e-6 in float, for random directions") {
  std::mt19937_64 random(3);
  double worst = 0.0, worst_float = 0.0, worst_uv = 0.0;
  for (int i = 0; i < 1000000; ++i) {
    const dvec3 d = random_direction(random);
    const CubePointD p = cube_from_direction(d);
    worst = std::max(worst, glm::length(direction_from_cube(p.face, p.uv) - d));
    const vec3 f(d);
    const shared::CubePoint pf = shared::cube_from_direction(f);
    worst_float = std::max(worst_float, glm::length(dvec3(shared::direction_from_cube(pf.face, pf.uv)) - dvec3(f)));
    const CubePointD pd = cube_from_direction(dvec3(f));  // the same float direction: the same face, ties included
    if (pd.face != pf.face) worst_uv = 1.0;
    worst_uv = std::max(worst_uv, glm::length(pd.uv - dvec2(pf.uv)));
  }
  CHECK(worst < 1e-12);
  CHECK(worst_float < 2e-6);
  CHECK(worst_uv < 2e-7);
}

TEST_CASE("edges and corners: u, v are exactly 0 or 1, ties go z, y, x, in double and float alike") {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (std::abs(x) + std::abs(y) + std::abs(z) < 2) continue;
        CAPTURE(x);
        CAPTURE(y);
        CAPTURE(z);
        for (const double scale : {1.0, 0.57735026918962573, 1.0 / 3.0, 6.4e6}) {
          const dvec3 d = scale * dvec3(x, y, z);
          const uint32_t expected = z ? (z > 0 ? 4u : 5u) : (y > 0 ? 2u : 3u);
          const CubePointD p = cube_from_direction(d);
          const shared::CubePoint pf = shared::cube_from_direction(vec3(d));
          CHECK(p.face == expected);
          CHECK(pf.face == expected);
          CHECK((p.uv == dvec2(pf.uv)));
          for (int k = 0; k < 2; ++k) CHECK((p.uv[k] == 0.0 || p.uv[k] == 0.5 || p.uv[k] == 1.0));
          const dvec3 back = direction_from_cube(p.face, p.uv);
          CHECK(glm::length(back - glm::normalize(d)) < 3e-16);
          CHECK(shared::cube_from_direction(shared::direction_from_cube(pf.face, pf.uv)).face == expected);
        }
      }
}

TEST_CASE("two faces that share an edge have the same directions along it") {
  // Every edge point of every face, approached from outside the face, lies on exactly one other face's edge.
  for (uint32_t f = 0; f < 6; ++f)
    for (int edge = 0; edge < 4; ++edge)
      for (int i = 1; i < 200; ++i) {
        const double a = i / 200.0;
        const dvec2 uv = edge == 0 ? dvec2(0, a) : edge == 1 ? dvec2(1, a) : edge == 2 ? dvec2(a, 0) : dvec2(a, 1);
        const dvec3 d = direction_from_cube(f, uv);
        const dvec2 beyond_uv = dvec2(0.5) + (uv - dvec2(0.5)) * (1.0 + 1e-9);
        const CubePointD other = cube_from_direction(direction_from_cube(f, beyond_uv));
        REQUIRE(other.face != f);
        REQUIRE(glm::length(direction_from_cube(other.face, other.uv) - d) < 2e-9);
        // The warp moves both faces' edge points alike.
        const dvec3 warped = direction_from_cube(f, cube_warp_uv(uv));
        const dvec3 warped_other = direction_from_cube(other.face, cube_warp_uv(other.uv));
        REQUIRE(glm::length(warped - warped_other) < 4e-9);
      }
}

TEST_CASE("solid angles of texels sum to 4 pi, and the float density agrees with them") {
  const int n = 64;
  double sum = 0.0, worst = 0.0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double omega = cube_solid_angle(dvec2(i, j) / double(n), dvec2(i + 1, j + 1) / double(n));
      sum += omega;
      const vec2 centre((float(i) + 0.5f) / float(n), (float(j) + 0.5f) / float(n));
      worst = std::max(worst, std::abs(shared::cube_solid_angle_density(centre) / (n * n) / omega - 1.0));
    }
  CHECK(std::abs(6.0 * sum - 4.0 * std::numbers::pi) < 1e-11);
  CHECK(worst < 3e-4);  // midpoint rule over 1/64 of a face
}

TEST_CASE("the tangent warp evens out texels to 1.414, and its polynomials hold 2e-7 and exact ends") {
  double least = 1e9, most = 0.0, worst = 0.0, worst_back = 0.0;
  const int n = 400;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double omega =
          cube_solid_angle(cube_unwarp_uv(dvec2(i, j) / double(n)), cube_unwarp_uv(dvec2(i + 1, j + 1) / double(n)));
      least = std::min(least, omega);
      most = std::max(most, omega);
    }
  CHECK(most / least > 1.40);
  CHECK(most / least < 1.4143);
  for (int i = 0; i <= 20000; ++i) {
    const float x = -1.0f + float(i) * 1e-4f;
    worst = std::max(worst, std::abs(double(shared::cube_warp(x)) - std::atan(double(x)) * 4.0 / std::numbers::pi));
    worst_back =
        std::max(worst_back, std::abs(double(shared::cube_unwarp(x)) - std::tan(double(x) * std::numbers::pi / 4)));
  }
  CHECK(worst < 3e-7);
  CHECK(worst_back < 3e-7);
  for (const float x : {-1.0f, 0.0f, 1.0f}) {
    CHECK(shared::cube_warp(x) == x);
    CHECK(shared::cube_unwarp(x) == x);
  }
  CHECK(cube_warp_uv(dvec2(0.0, 1.0)) == dvec2(0.0, 1.0));
  CHECK(cube_unwarp_uv(dvec2(0.0, 1.0)) == dvec2(0.0, 1.0));
}

TEST_CASE("a warped map is read where it was written: the sampler's own coordinates of the warped direction") {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20000; ++i) {
    const vec3 d(random_direction(random));
    const shared::CubePoint at = shared::cube_from_direction(d);
    const shared::CubePoint read = shared::cube_from_direction(shared::cube_warped_direction(d));
    REQUIRE(read.face == at.face);
    REQUIRE(glm::length(read.uv - shared::cube_warp_uv(at.uv)) < 1e-6f);
    const vec3 back = shared::direction_from_cube(at.face, shared::cube_unwarp_uv(read.uv));
    REQUIRE(glm::length(back - d) < 2e-6f);
  }
}
