#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <random>

#include "clouds/shadow_cascades.h"
#include "clouds/shadow_map_shared.h"
#include "geo/frames.h"
#include "geo/planet_view.h"

namespace nepho {
namespace {

TEST_CASE("splits: uniform and logarithmic as their formulas say, practical between them, the last ends at the range") {
  CloudShadowParams params;
  params.cascades = 4;
  const double near_m = 500.0, far_m = 8000.0;  // a ratio of 2 each
  params.split = "uniform";
  const auto uniform = shadow_slices(params, near_m, far_m);
  params.split = "logarithmic";
  const auto logarithmic = shadow_slices(params, near_m, far_m);
  params.split = "practical";
  const auto practical = shadow_slices(params, near_m, far_m);
  for (uint32_t i = 0; i < 4; ++i) {
    CHECK(uniform[i].far_m == doctest::Approx(500.0 + 1875.0 * (i + 1)));
    CHECK(logarithmic[i].far_m == doctest::Approx(500.0 * std::exp2(i + 1.0)));
    CHECK(practical[i].far_m == doctest::Approx(0.6 * logarithmic[i].far_m + 0.4 * uniform[i].far_m));
    CHECK(practical[i].near_m <= practical[i].fade_m);
    CHECK(practical[i].fade_m < practical[i].far_m);
    if (i > 0) CHECK(practical[i].near_m == practical[i - 1].fade_m);  // they overlap where they fade
  }
  CHECK(practical[0].near_m == near_m);
  CHECK(shadow_slices(params, 0.0, far_m)[0].near_m == 0.0);  // on the ground from the camera on
}

TEST_CASE("the range is tens of kilometres on the ground and the visible disc from orbit") {
  CHECK(automatic_shadow_range_m(2.0, 2500.0) > 20e3);
  CHECK(automatic_shadow_range_m(2.0, 2500.0) < 60e3);
  // Tangent from a geostationary orbit: sqrt(r^2 - a^2), and clouds of 10 km beyond it.
  const double r = 42164e3, a = 6378137.0, top = 10e3;
  CHECK(automatic_shadow_range_m(r - a, top) ==
        doctest::Approx(std::sqrt(r * r - a * a) + std::sqrt(top * (2 * a + top))).epsilon(1e-9));
  double last = 0.0;
  for (double h = 1.0; h < 1e8; h *= 1.3) {
    CHECK(automatic_shadow_range_m(h, 2500.0) >= last);
    last = automatic_shadow_range_m(h, 2500.0);
  }
}

TEST_CASE("the ball about a slice from the camera on goes through the camera and the far rim: f / (2 cos t)") {
  for (const double angle : {0.2, 0.5, 0.7}) {
    const SliceBall ball = ball_of_slice(0.0, 1000.0, angle);
    CHECK(ball.radius_m == doctest::Approx(500.0 / std::cos(angle)).epsilon(1e-6));
    CHECK(ball.ahead_m == doctest::Approx(500.0 / std::cos(angle)).epsilon(1e-6));
  }
  // A wide one is about the circle of its far rim.
  CHECK(ball_of_slice(0.0, 1000.0, 1.3).radius_m == doctest::Approx(1000.0 * std::sin(1.3)).epsilon(1e-4));
}

TEST_CASE("axes across the light are orthonormal, wherever it is") {
  for (const glm::dvec3 light : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0.3, -0.4, 0.5)}) {
    const LightAxes axes = LightAxes::towards(light);
    CHECK(std::abs(length(axes.x) - 1.0) < 1e-12);
    CHECK(std::abs(length(axes.y) - 1.0) < 1e-12);
    CHECK(std::abs(dot(axes.x, axes.light)) < 1e-12);
    CHECK(length(cross(axes.x, axes.y) - axes.light) < 1e-12);
    CHECK(length(axes.light - normalize(light)) < 1e-12);
  }
}

TEST_CASE("every point in view lies in a tile that is marked") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double height_m : {2.0, 1700.0, 12e3, 400e3}) {
    const Geodetic at = Geodetic::from_degrees(34.9, 138.1, height_m);
    const dmat4 ecef_from_enu = make_ecef_from_enu(at);
    shared::FrameConstants frame{};
    const dvec3 camera = ecef_from_geodetic(at);
    frame.planet = make_planet_view(camera);
    const auto axis = [&](const dvec3& enu) { return glm::vec3(dvec3(ecef_from_enu * glm::dvec4(enu, 0.0))); };
    const double pitch = height_m > 5e3 ? -0.7 : -0.05;
    frame.forward = axis({0.0, std::cos(pitch), std::sin(pitch)});
    frame.right = axis({0.74, 0.0, 0.0});
    frame.up = axis({0.0, -0.41 * std::sin(pitch), 0.41 * std::cos(pitch)});
    const LightAxes axes = LightAxes::towards(dvec3(axis({0.3, -0.4, 0.8})));
    const double near_m = std::max(height_m - 2.4e3, 0.0), far_m = automatic_shadow_range_m(height_m, 2400.0);
    ShadowGrid grid{.tiles = 64, .tile_m = 2.2 * far_m / 64};
    grid.first_x = static_cast<int64_t>(std::floor(dot(camera, axes.x) / grid.tile_m)) - 32;
    grid.first_y = static_cast<int64_t>(std::floor(dot(camera, axes.y) / grid.tile_m)) - 32;
    const auto tiles = tiles_in_view(frame, camera, axes, grid, near_m, far_m, -600.0, 2400.0);
    size_t points = 0, marked = 0;
    for (int i = 0; i < 200000 && points < 2000; ++i) {
      const dvec3 dir = normalize(dvec3(frame.forward) + (2 * unit(random) - 1) * dvec3(frame.right) +
                                  (2 * unit(random) - 1) * dvec3(frame.up));
      const dvec3 p = camera + dir * (near_m + (far_m - near_m) * unit(random));
      const double h = geodetic_from_ecef(p).height_m;
      if (h < 0.0 || h > 2400.0) continue;
      ++points;
      const auto x = static_cast<int64_t>(std::floor(dot(p, axes.x) / grid.tile_m)) - grid.first_x;
      const auto y = static_cast<int64_t>(std::floor(dot(p, axes.y) / grid.tile_m)) - grid.first_y;
      REQUIRE((x >= 0 && y >= 0 && x < 64 && y < 64));
      marked += tiles[static_cast<size_t>(y) * 64 + static_cast<size_t>(x)];
    }
    INFO(height_m);
    CHECK(points > 500);
    CHECK(marked == points);
    size_t all = 0;
    for (const uint8_t t : tiles) all += t;
    CHECK(all < tiles.size() * 3 / 4);  // and not simply everything
  }
}

TEST_CASE("widened() adds a ring of tiles, surrounded() takes it off again") {
  std::vector<uint8_t> one(100, 0);
  one[45] = 1;
  const auto nine = widened(one, 10);
  size_t count = 0;
  for (const uint8_t t : nine) count += t;
  CHECK(count == 9);
  CHECK(surrounded(nine, 10) == one);
}

TEST_CASE("a packed texel gives back its knots, lines between them, and its whole depth behind") {
  shared::ShadowTexel texel{};
  for (int i = 0; i < 6; ++i) texel.at[i] = 1000.0f + 2000.0f * static_cast<float>(i);
  texel.depth = 5.2f;
  texel.end = 20000.0f;
  const glm::uvec4 packed = shared::shadow_pack(texel);
  for (int i = 0; i < 6; ++i)
    CHECK(shared::shadow_depth_at(packed, texel.at[i]) == doctest::Approx(shared::shadow_knot(i)).epsilon(1e-5));
  CHECK(shared::shadow_depth_at(packed, 2000.0f) == doctest::Approx(0.125f));
  CHECK(shared::shadow_depth_at(packed, 15500.0f) == doctest::Approx(3.2f + 1.0f).epsilon(1e-3));
  CHECK(shared::shadow_depth_at(packed, 0.0f) == 0.0f);
  CHECK(shared::shadow_depth_at(packed, 65535.0f) == doctest::Approx(5.2f).epsilon(1e-4));
}

TEST_CASE("a texel of optical depth 0.4 rises along the line to the knot that it never reaches") {
  shared::ShadowTexel texel{};
  texel.at[0] = 1000.0f;
  texel.at[1] = 2000.0f;
  texel.at[2] = 2000.0f + 3000.0f * 0.35f / 0.15f;  // 0.4 at 5000 lies on the line
  texel.at[3] = texel.at[4] = texel.at[5] = 65535.0f;
  texel.depth = 0.4f;
  texel.end = 5000.0f;
  const glm::uvec4 packed = shared::shadow_pack(texel);
  CHECK(shared::shadow_depth_at(packed, 3500.0f) == doctest::Approx(0.325f).epsilon(1e-3));
  CHECK(shared::shadow_depth_at(packed, 5000.0f) == doctest::Approx(0.4f).epsilon(1e-3));
  CHECK(shared::shadow_depth_at(packed, 60000.0f) == doctest::Approx(0.4f).epsilon(1e-3));
}

TEST_CASE("storage places of a window are all different, whatever its first") {
  shared::ShadowCascade cascade{};
  cascade.first = {24, 40};
  std::vector<uint8_t> used(64 * 64, 0);
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const glm::uvec2 place = shared::shadow_place(cascade, {x, y}, 64);
      REQUIRE((place.x < 64 && place.y < 64));
      ++used[place.y * 64 + place.x];
    }
  for (const uint8_t n : used) CHECK(n == 1);
}

}  // namespace
}  // namespace nepho
