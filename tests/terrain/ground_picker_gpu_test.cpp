// Picks against pixels: the ray caster works in double on the triangles that the rasteriser draws in floats.
#include "terrain/ground_picker.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "gpu/gpu_fixture.h"
#include "terrain_draw.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr Extent2D kExtent{112, 63};

}  // namespace

TEST_CASE("gpu: a pick is where the pixel is drawn, within the depth buffer's floats and its snapped vertices") {
  // Vulkan snaps vertices to 1/256 pixel (VkPhysicalDeviceLimits::subPixelPrecisionBits 8 on lavapipe), so that what is
  // drawn at a pixel's centre may be what a ray up to 1/512 pixel beside it meets on each axis, and a little more where
  // floats move the vertex itself: 1e-4 pixel. Along the ray: near / w in a float, 2^-24 of it, interpolated between
  // vertices that may be much nearer, and turned back by two divisions.
  constexpr double kBeside_px = 1.0 / 512 + 2e-4, kAlong = 2e-6;
  struct Camera {
    double lat, lon, height, heading, pitch, fov;
  };
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {rough_world()};
  Terrain terrain(gpu.device, std::move(sources), {});
  double worst = 0.0;
  for (const Camera& c :
       {Camera{35.0, 138.0, 4500.0, 30.0, -5.0, 60.0}, Camera{35.01, 138.02, 3000.0, 200.0, -30.0, 45.0},
        Camera{-89.99, 30.0, 9000.0, 300.0, -30.0, 60.0}, Camera{10.0, 180.0, 20e3, 10.0, -15.0, 60.0},
        Camera{0.0, -179.9, 400e3, 270.0, -30.0, 60.0}, Camera{50.0, 50.0, 8e6, 0.0, -80.0, 60.0},
        Camera{20.0, 50.0, 36e6, 0.0, -90.0, 22.0}}) {
    CAPTURE(c.height);
    const FrameInfo frame =
        frame_at(Geodetic::from_degrees(c.lat, c.lon, c.height), Attitude::from_degrees(c.heading, c.pitch), c.fov,
                 kExtent, glm::vec2(0.3f, -0.2f));
    const std::vector<float> depth = draw_terrain(gpu, terrain, frame).depth_m;
    const GroundPicker picker(terrain, frame);
    size_t ground = 0, wrong = 0, edges = 0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
      for (uint32_t x = 0; x < kExtent.width; ++x) {
        const auto drawn = static_cast<double>(depth[y * kExtent.width + x]);
        // Where a ridge hides what is behind it, the rays beside the pixel's tell how far apart the two are.
        double low = std::numeric_limits<double>::infinity(), high = 0.0;
        const auto look = [&](double dx, double dy) {
          const std::optional<GroundHit> hit = picker.at(x + 0.5 + dx * kBeside_px, y + 0.5 + dy * kBeside_px);
          const double t = hit ? hit->distance_m : 1e10;
          low = std::min(low, t);
          high = std::max(high, t);
        };
        const auto beyond = [&] { return std::max(low / drawn - 1.0, drawn / high - 1.0); };
        for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {-1.0, -1.0}, {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}})
          look(dx, dy);
        // A peak may reach in between the corners.
        for (int k = 0; k < 81 && beyond() > kAlong; ++k) look(k % 9 / 4.0 - 1.0, k / 9 / 4.0 - 1.0);
        worst = std::max(worst, beyond());
        wrong += beyond() > kAlong;
        edges += high > 1.01 * low;
        ground += drawn < 1e9;
      }
    CHECK(ground > kExtent.width * kExtent.height / 4);
    CHECK(edges < ground / 20);  // the interval says something
    // Around a pole a mesh cell is kilometres long and metres wide: snapping its corners tilts it. On the limb a
    // snapped peak may hide what none of these rays misses.
    CHECK(wrong <= (std::abs(c.lat) > 89.0 ? kExtent.width * kExtent.height / 500 : 1));
  }
  MESSAGE("beyond the interval by " << worst << " of the distance at most");
}

TEST_CASE("gpu: a pick through a place of the picture hits the plain ellipsoid where the closed form says") {
  GpuFixture gpu;
  Terrain terrain(gpu.device, {}, {});
  const FrameInfo frame =
      frame_at(Geodetic::from_degrees(35.0, 138.0, 2.0), Attitude::from_degrees(30.0, -10.0), 45.0, kExtent);
  terrain.prepare(frame);
  const GroundPicker picker(terrain, frame);
  // Below by the sagitta of the mesh's cells there: 0.2 mm at most.
  for (const auto& [x, y] : {std::pair{56.0, 62.3}, {7.25, 49.0}, {112.0, 63.0}}) {
    const std::optional<GroundHit> hit = picker.at(x, y);
    REQUIRE(hit.has_value());
    const double t = hit_ellipsoid(frame.camera_ecef_m, picker.ray(x, y));
    CHECK(std::abs(hit->distance_m - t) < 2e-3 * t);
    CHECK(std::abs(geodetic_from_ecef(hit->point_ecef_m).height_m) < 2e-3);
    CHECK(glm::length(hit->point_ecef_m - frame.camera_ecef_m - hit->distance_m * picker.ray(x, y)) < 1e-8);
    CHECK(glm::dot(hit->normal, geodetic_up_ecef(rad_from_deg(35.0), rad_from_deg(138.0))) > 1.0 - 1e-6);
  }
  CHECK_FALSE(picker.at(56.0, 1.0).has_value());  // 10 degrees above the horizon
}
