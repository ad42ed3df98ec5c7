#include "terrain/ground_map.h"

#include <doctest/doctest.h>

#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "gpu/pipeline.h"
#include "ground_fixture.h"
#include "terrain/test_ground.comp.h"
#include "test_rasters.h"

using namespace nepho;
using namespace nepho::test;
using glm::dvec2;
using glm::vec2;
using glm::vec4;

namespace {

struct Ground {
  double albedo, water, height_m;
};

/// What a shader reads at places of the map's plane.
std::vector<Ground> look_up(GpuFixture& gpu, const GroundMap& ground, const std::vector<dvec2>& xy) {
  static const gpu::ComputePipeline pipeline(gpu.device, {.name = "test.ground", .spirv = test_ground_comp});
  std::vector<vec4> at;
  for (const dvec2& p : xy) at.push_back(vec4(shared::region_direction(ground.map(), vec2(p)), 0.0f));
  FrameGraph graph;
  const GroundMap::Refs refs = ground.import_into(graph);
  const BufferRef values = graph.create_buffer("values", at.size() * 2 * sizeof(vec4));
  graph.pass("test.ground")
      .sample("ground_albedo_tex", refs.albedo)
      .sample("ground_height_tex", refs.height_m)
      .uniform("region", graph.constants("region", ground.map()))
      .read("directions", graph.constants("directions", at))
      .write("values", values)
      .record([&](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(static_cast<uint32_t>(at.size())); });
  graph.keep(values);
  gpu.executor.run(graph);
  const std::vector<vec4> read = gpu.executor.read<vec4>(values);
  std::vector<Ground> out;
  for (size_t i = 0; i < at.size(); ++i) {
    const vec4 &a = read[2 * i], &h = read[2 * i + 1];
    REQUIRE(a.x == a.y);
    REQUIRE(a.x == a.z);
    REQUIRE(h.x == h.y);
    out.push_back({static_cast<double>(a.x), static_cast<double>(a.w), static_cast<double>(h.x)});
  }
  return out;
}

dvec3 up_of(const shared::RegionMap& map, const dvec2& xy) {
  const Geodetic at = geodetic_from_map_direction(dvec3(shared::region_direction(map, vec2(xy))));
  return geodetic_up_ecef(at.lat_rad, at.lon_rad);
}

constexpr double kPlaces[][2] = {{20.0, 30.0}, {-40.0, 179.9999}, {89.99, 10.0}, {-90.0, 0.0}};

}  // namespace

TEST_CASE(
    "gpu: the ground map gives the ground's height and colour from 10 m to 9000 km, over antimeridian and poles") {
  GpuFixture gpu;
  const HeightSampler heights({smooth_elevation()}, true, nullptr);
  const ImagerySampler imagery({smooth_imagery()}, heights);
  GroundMap ground(gpu.device);
  for (const auto& place : kPlaces) {
    ground.update(heights, imagery, map_at(place[0], place[1]));
    std::vector<dvec2> xy;
    for (double r = 10.0; r < 9e6; r *= 1.5)
      for (double azimuth = 0.2; azimuth < 6.2; azimuth += 0.61)
        xy.push_back(r * dvec2(std::cos(azimuth), std::sin(azimuth)));
    const std::vector<Ground> got = look_up(gpu, ground, xy);
    for (size_t i = 0; i < xy.size(); ++i) {
      CAPTURE(place[0]);
      CAPTURE(glm::length(xy[i]));
      const dvec3 up = up_of(ground.map(), xy[i]);
      REQUIRE(got[i].height_m == doctest::Approx(smooth_height_m(up)).epsilon(4e-3));
      REQUIRE(got[i].albedo == doctest::Approx(linear_from_srgb(smooth_srgb(up))).epsilon(0.01));
      REQUIRE(got[i].water == 0.0);
    }
  }
}

TEST_CASE("gpu: across the borders of its levels the ground map changes by no more than a texel does") {
  GpuFixture gpu;
  const HeightSampler heights({smooth_elevation()}, true, nullptr);
  const ImagerySampler imagery({smooth_imagery()}, heights);
  GroundMap ground(gpu.device);
  for (const auto& place : kPlaces) {
    ground.update(heights, imagery, map_at(place[0], place[1]));
    const shared::RegionMap& map = ground.map();
    std::vector<dvec2> xy;
    std::vector<uint32_t> levels;
    for (uint32_t level = 0; level + 1 < map.levels; ++level)
      // Where a level is left (between its outermost texel centres and its rim), on all four sides.
      for (const double edge : {127.0 / 128.0, 1.0})
        for (const double along : {-0.8, 0.0, 0.55})
          for (int side = 0; side < 4; ++side)
            for (const double step : {-1e-5, 1e-5}) {
              const double half = static_cast<double>(shared::region_half_m(map, level));
              const dvec2 p = half * dvec2(side % 2 ? edge + step : -edge - step, along);
              xy.push_back(side < 2 ? p : dvec2(p.y, p.x));
              levels.push_back(level);
            }
    const std::vector<Ground> got = look_up(gpu, ground, xy);
    for (size_t i = 0; i < xy.size(); i += 2) {
      CAPTURE(place[0]);
      CAPTURE(levels[i]);
      // The steepest that the smooth heights and colours get, over a texel of the coarser level.
      const double texel_rad = texel_m(map, levels[i] + 1) / 6378137.0;
      REQUIRE(std::abs(got[i].height_m - got[i + 1].height_m) < 0.05 + 800.0 * texel_rad);
      REQUIRE(std::abs(got[i].albedo - got[i + 1].albedo) < 1e-3 + 0.4 * texel_rad);
    }
  }
}

TEST_CASE("gpu: in sequences the ground map stays while it serves, and the next one may come from the background") {
  GpuFixture gpu;
  const HeightSampler heights({smooth_elevation()}, true, nullptr);
  const ImagerySampler imagery({smooth_imagery()}, heights);
  GroundMap ground(gpu.device), exact(gpu.device);
  const auto at = [](double lat_deg) { return map_at(lat_deg, 30.0, 4, 4e3); };
  const auto follows = [&](double lat_deg, GroundMap::Follow how) {
    ground.update(heights, imagery, at(lat_deg), how);
    return ground.map().centre == at(lat_deg).centre;
  };
  CHECK(follows(20.0, GroundMap::Follow::in_background));  // the first picture waits
  CHECK_FALSE(follows(20.005, GroundMap::Follow::near));   // 550 m of 1 km
  CHECK(follows(20.005, GroundMap::Follow::exactly));
  CHECK(follows(20.02, GroundMap::Follow::near));
  CHECK_FALSE(follows(20.05, GroundMap::Follow::in_background));
  for (int i = 0; i < 6000 && !follows(20.05, GroundMap::Follow::in_background); ++i) sleep_s(0.01);
  CHECK(follows(20.05, GroundMap::Follow::near));
  exact.update(heights, imagery, at(20.05));
  const std::vector<dvec2> xy = {{10.0, 20.0}, {-3e3, 500.0}, {20e3, -30e3}};
  const std::vector<Ground> got = look_up(gpu, ground, xy), wanted = look_up(gpu, exact, xy);
  for (size_t i = 0; i < xy.size(); ++i) {
    CHECK(got[i].height_m == wanted[i].height_m);
    CHECK(got[i].albedo == wanted[i].albedo);
  }
  // One that is still being made for a place that was left holds nobody up.
  follows(20.2, GroundMap::Follow::in_background);
  CHECK(follows(20.5, GroundMap::Follow::exactly));
}

TEST_CASE("gpu: beyond its last level the ground map gives its rim") {
  GpuFixture gpu;
  const HeightSampler heights({smooth_elevation()}, true, nullptr);
  const ImagerySampler imagery({smooth_imagery()}, heights);
  GroundMap ground(gpu.device);
  ground.update(heights, imagery, map_at(20.0, 30.0, 2, 400e3));
  const double rim = 800e3 * (127.0 / 128.0);
  const std::vector<Ground> got = look_up(gpu, ground, {{rim, 100e3}, {12e6, 100e3}, {-rim, -rim}, {-4e6, -8e6}});
  CHECK(got[1].height_m == doctest::Approx(got[0].height_m).epsilon(1e-5));
  CHECK(got[1].albedo == doctest::Approx(got[0].albedo).epsilon(1e-3));
  CHECK(got[3].height_m == doctest::Approx(got[2].height_m).epsilon(1e-5));
  CHECK(std::abs(got[0].height_m - got[2].height_m) > 50.0);
}

TEST_CASE("gpu: at a coast the ground map mixes water and land, and the land keeps its albedo") {
  GpuFixture gpu;
  const HeightSampler heights(
      {raster_of(3600, 1800, {}, [](double, double lon) { return lon > 0.0 ? 100.0 : -100.0; })}, true, nullptr);
  const ImagerySampler imagery({}, heights, 0.4);
  GroundMap ground(gpu.device);
  ground.update(heights, imagery, map_at(10.0, 0.0, 6));
  const shared::RegionMap first = ground.map();
  std::vector<dvec2> xy;
  for (int i = -40; i <= 40; ++i) xy.push_back({i * 10.0, 3000.0});
  xy.push_back({-200e3, 1000.0});
  xy.push_back({200e3, 1000.0});
  const std::vector<Ground> got = look_up(gpu, ground, xy);
  double last = 1.0;
  for (size_t i = 0; i <= 80; ++i) {
    REQUIRE(got[i].water <= last + 1e-6);
    last = got[i].water;
    if (got[i].water < 0.999) REQUIRE(got[i].albedo == doctest::Approx(0.4).epsilon(0.01));
  }
  CHECK(got[0].water == 1.0);
  CHECK(got[40].water == doctest::Approx(0.5).epsilon(0.1));
  CHECK(got[80].water == 0.0);
  CHECK(got[81].water == 1.0);
  CHECK(got[81].height_m == 0.0);
  CHECK(got[82].water == 0.0);
  CHECK(got[82].height_m == doctest::Approx(100.0));
  // Another place, with other levels: everything follows.
  ground.update(heights, imagery, map_at(10.0, 3.0, 8));
  CHECK(ground.map().levels == 8u);
  CHECK(ground.map().centre != first.centre);
  CHECK(look_up(gpu, ground, {{0.0, 3000.0}})[0].water == 0.0);
}
