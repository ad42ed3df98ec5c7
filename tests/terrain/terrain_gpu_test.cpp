#include "terrain/terrain.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <glm/gtc/packing.hpp>

#include "gpu/gpu_fixture.h"
#include "terrain_draw.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr Extent2D kExtent{320, 180};
constexpr float kSky = 1.0e10f;

struct Camera {
  double lat, lon, height, heading, pitch, fov;
};

}  // namespace

TEST_CASE("gpu: the plain ellipsoid is hit where the closed form says, from 2 m to 36,000 km, without holes") {
  GpuFixture gpu;
  Terrain terrain(gpu.device, {}, {});
  for (const Camera& c : {Camera{35.0, 138.0, 2.0, 30.0, -10.0, 60.0}, Camera{-60.0, -180.0, 100.0, 300.0, -30.0, 60.0},
                          Camera{90.0, 0.0, 10e3, 0.0, -5.0, 60.0}, Camera{0.0, 179.9, 400e3, 90.0, -20.0, 60.0},
                          Camera{-89.0, 10.0, 2e6, 0.0, -60.0, 60.0}, Camera{20.0, 50.0, 36e6, 0.0, -90.0, 22.0}}) {
    CAPTURE(c.height);
    const FrameInfo frame =
        frame_at(Geodetic::from_degrees(c.lat, c.lon, c.height), Attitude::from_degrees(c.heading, c.pitch), c.fov,
                 kExtent, glm::vec2(0.3f, -0.2f));
    const DrawnTerrain drawn = draw_terrain(gpu, terrain, frame);
    const auto pixel = static_cast<double>(frame.constants.pixel_angle_rad);
    size_t hits = 0, holes = 0, wrong = 0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
      for (uint32_t x = 0; x < kExtent.width; ++x) {
        const float depth = drawn.depth_m[y * kExtent.width + x];
        // Silhouettes may be half a pixel off.
        bool all_hit = true, any_hit = false;
        for (const double dy : {-0.5, 0.5})
          for (const double dx : {-0.5, 0.5}) {
            const bool hit = hit_ellipsoid(frame.camera_ecef_m, pixel_ray(frame, x + 0.5 + dx, y + 0.5 + dy)) > 0.0;
            all_hit &= hit;
            any_hit |= hit;
          }
        if (!any_hit) REQUIRE(depth == kSky);
        if (!all_hit) continue;
        ++hits;
        if (depth == kSky) {
          ++holes;
          continue;
        }
        const dvec3 ray = pixel_ray(frame, x + 0.5, y + 0.5);
        const double t = hit_ellipsoid(frame.camera_ecef_m, ray);
        const dvec3 p = frame.camera_ecef_m + ray * static_cast<double>(depth);
        // Off the ellipsoid by at most the level's error (half a pixel there), which grazing rays meet later; and the
        // depth buffer's own 1e-5.
        const double height = std::abs(geodetic_from_ecef(p).height_m);
        if (height > 0.5 * pixel * t + 2e-5 * t) ++wrong;
      }
    CHECK(hits > 3000);
    CHECK(holes == 0);
    CHECK(wrong == 0);
  }
}

TEST_CASE("gpu: rough ground has no hole inside the silhouette") {
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {rough_world()};
  Terrain terrain(gpu.device, std::move(sources), {});
  for (const Camera& c :
       {Camera{35.0, 138.0, 4500.0, 30.0, -5.0, 60.0}, Camera{-89.99, 30.0, 9000.0, 300.0, -30.0, 60.0},
        Camera{10.0, 180.0, 20e3, 10.0, -15.0, 60.0}, Camera{0.0, -179.9, 400e3, 270.0, -30.0, 60.0},
        Camera{50.0, 50.0, 8e6, 0.0, -80.0, 60.0}}) {
    CAPTURE(c.height);
    const FrameInfo frame = frame_at(Geodetic::from_degrees(c.lat, c.lon, c.height),
                                     Attitude::from_degrees(c.heading, c.pitch), c.fov, kExtent);
    const DrawnTerrain drawn = draw_terrain(gpu, terrain, frame);
    size_t hits = 0, holes = 0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
      for (uint32_t x = 0; x < kExtent.width; ++x) {
        if (hit_ellipsoid(frame.camera_ecef_m, pixel_ray(frame, x + 0.5, y + 0.5)) < 0.0)
          continue;  // the ground is higher
        ++hits;
        holes += drawn.depth_m[y * kExtent.width + x] == kSky;
      }
    CHECK(hits > 10000);
    CHECK(holes == 0);
  }
}

TEST_CASE("gpu: a cone is hit within its level's error, and its normals lean outwards") {
  // 3000 m high, 20 km wide at the equator; 100 m pixels.
  constexpr double kDegree = 111319.49;
  const auto cone = raster_of(400, 400, {-0.18, -0.18, 0.18, 0.18}, [](double lat, double lon) {
    return std::max(0.5, 3000.0 - 0.3 * kDegree * std::hypot(lat, lon));
  });
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {cone};
  Terrain terrain(gpu.device, std::move(sources), {});
  CHECK(terrain.ground_height_m(0.0, rad_from_deg(0.05)) ==
        doctest::Approx(3000.0 - 0.3 * kDegree * 0.05).epsilon(1e-3));
  const Geodetic at = Geodetic::from_degrees(-0.15, 0.0, 2000.0);
  const FrameInfo frame = frame_at(at, Attitude::from_degrees(0.0, 0.0), 45.0, {641, 361});
  const DrawnTerrain drawn = draw_terrain(gpu, terrain, frame);
  size_t compared = 0;
  for (const uint32_t y : {100u, 180u, 240u})
    for (const uint32_t x : {200u, 320u, 400u}) {
      // March the true surface.
      const dvec3 ray = pixel_ray(frame, x + 0.5, y + 0.5);
      double t = 0.0;
      const auto above = [&](double at_t) {
        const Geodetic g = geodetic_from_ecef(frame.camera_ecef_m + ray * at_t);
        return g.height_m - terrain.ground_height_m(g.lat_rad, g.lon_rad);
      };
      while (t < 40e3 && above(t) > 0.0) t += 20.0;
      const float depth = drawn.depth_m[y * 641 + x];
      if (t >= 40e3) {
        CHECK(depth == kSky);
        continue;
      }
      ++compared;
      CHECK(std::abs(static_cast<double>(depth) - t) < 60.0);
    }
  CHECK(compared >= 5);
  // The centre of the picture sees the southern slope: its normal has 0.3 to the south (-z at the equator).
  const size_t centre = (180 * 641 + 320) * 4;
  const auto half = [&](size_t i) { return static_cast<double>(glm::unpackHalf1x16(drawn.normal[i])); };
  CHECK(half(centre) == doctest::Approx(1.0 / std::sqrt(1.09)).epsilon(0.01));
  CHECK(half(centre + 2) == doctest::Approx(-0.3 / std::sqrt(1.09)).epsilon(0.05));
  CHECK(half(centre + 3) == 0.0);
  CHECK(static_cast<double>(glm::unpackHalf1x16(drawn.albedo[centre + 3])) == 1.0);
  CHECK(static_cast<double>(glm::unpackHalf1x16(drawn.albedo[centre])) == doctest::Approx(0.2).epsilon(0.02));
}

TEST_CASE("gpu: the mask tells sea from land at the coast of the default data") {
  // Land east of the meridian of Greenwich.
  const auto world = raster_of(720, 360, {}, [](double, double lon) { return lon > 0.0 ? 20.0 : -20.0; });
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {world};
  sources.has_default = true;
  Terrain terrain(gpu.device, std::move(sources), {});
  const FrameInfo frame =
      frame_at(Geodetic::from_degrees(0.0, 0.0, 100e3), Attitude::from_degrees(0.0, -90.0), 45.0, kExtent);
  const DrawnTerrain drawn = draw_terrain(gpu, terrain, frame);
  for (const uint32_t y : {10u, 90u, 170u}) {
    const auto mask = [&](uint32_t x) {
      return static_cast<double>(glm::unpackHalf1x16(drawn.albedo[(y * 320 + x) * 4 + 3]));
    };
    CHECK(mask(150) == 2.0);
    CHECK(mask(170) == 1.0);
    uint32_t changes = 0;
    for (uint32_t x = 1; x < 320; ++x) changes += mask(x) != mask(x - 1);
    CHECK(changes == 1);
  }
}

TEST_CASE("gpu: a second frame of the same view loads nothing and draws the same bits") {
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {rough_world()};
  Terrain terrain(gpu.device, std::move(sources), {});
  const FrameInfo frame =
      frame_at(Geodetic::from_degrees(20.0, 30.0, 9e3), Attitude::from_degrees(0.0, -10.0), 45.0, kExtent);
  const DrawnTerrain first = draw_terrain(gpu, terrain, frame);
  CHECK(terrain.stats().tiles_loaded > 10);
  const DrawnTerrain second = draw_terrain(gpu, terrain, frame);
  CHECK(terrain.stats().tiles_loaded == 0);
  CHECK(first.depth_m == second.depth_m);
  CHECK(first.albedo == second.albedo);
  CHECK(first.normal == second.normal);
}

TEST_CASE("gpu: a view of nothing but sky draws sky") {
  GpuFixture gpu;
  Terrain terrain(gpu.device, {}, {});
  const DrawnTerrain drawn = draw_terrain(
      gpu, terrain, frame_at(Geodetic::from_degrees(0.0, 0.0, 1e6), Attitude::from_degrees(0.0, 80.0), 45.0, kExtent));
  CHECK(std::all_of(drawn.depth_m.begin(), drawn.depth_m.end(), [](float d) { return d == kSky; }));
}
