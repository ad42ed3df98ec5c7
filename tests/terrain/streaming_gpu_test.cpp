// The ground while data are still being read: what is drawn at once, and that it ends as the whole picture.
#include <doctest/doctest.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "gpu/gpu_fixture.h"
#include "terrain_draw.h"
#include "terrain_fixture.h"
#include "test_rasters.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr float kSky = 1.0e10f;
const TerrainWait kAtOnce{.complete = false, .at_most_s = 0.0};
const TerrainWait kMoment{.complete = false, .at_most_s = 0.1};

/// Holds up those who read a raster while it is shut.
class Gate {
 public:
  void open() {
    {
      const std::lock_guard lock(mutex_);
      open_ = true;
    }
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++waited_for_;
    changed_.wait(lock, [&] { return open_; });
  }
  int waited_for() {
    const std::lock_guard lock(mutex_);
    return waited_for_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  int waited_for_ = 0;
};

/// Twenty degrees of heights from 0 to 1600 m with pixels of 20 / side degrees.
std::shared_ptr<PlaneRaster> ramp(uint32_t side) {
  auto raster = std::make_shared<PlaneRaster>(side, side);
  raster->info_.bounds = {10.0, 20.0, 30.0, 40.0};
  raster->value_scale = 320.0 / side;
  return raster;
}

FrameInfo from_far() {
  return frame_at(Geodetic::from_degrees(30.0, 20.0, 6e6), Attitude::from_degrees(0.0, -90.0), 45.0, {96, 64});
}

Terrain make_terrain(GpuFixture& gpu, std::shared_ptr<Raster> raster) {
  TerrainSources sources;
  sources.elevation = {std::move(raster)};
  sources.caches = {.memory = std::make_shared<HostBudget>(256u << 20), .disk = nullptr, .timeout_s = 0.0};
  return Terrain(gpu.device, std::move(sources), {});
}

/// No sky in the middle of the picture; its corners look past the Earth.
bool is_whole(const DrawnTerrain& drawn) {
  for (size_t y = 16; y < 48; ++y)
    for (size_t x = 24; x < 72; ++x)
      if (drawn.depth_m[y * 96 + x] == kSky) return false;
  return true;
}

/// Frames until nothing is missing.
DrawnTerrain finished(GpuFixture& gpu, Terrain& terrain) {
  for (int frame = 0; frame < 600; ++frame) {
    const DrawnTerrain drawn = draw_terrain(gpu, terrain, from_far(), kMoment);
    if (terrain.stats().tiles_missing == 0) return drawn;
  }
  FAIL("something is missing after 600 frames");
  return {};
}

}  // namespace

TEST_CASE("gpu: a large raster without a pyramid is left out of the first picture, and there in the end") {
  GpuFixture gpu;
  const auto raster = ramp(16384);
  Gate gate;
  Terrain terrain = make_terrain(gpu, raster);
  raster->before = [&](uint32_t, uint32_t, uint32_t, uint64_t) {
    gate.pass();
    return true;
  };
  const DrawnTerrain first = draw_terrain(gpu, terrain, from_far(), kAtOnce);
  CHECK(is_whole(first));
  CHECK(terrain.stats().tiles_missing > 0);
  gate.open();
  const DrawnTerrain last = finished(gpu, terrain);
  CHECK(gate.waited_for() >= 64);  // blocks of 2048 x 2048 pixels
  CHECK(last.depth_m != first.depth_m);
  // Another one that waits for everything.
  Terrain patient = make_terrain(gpu, ramp(16384));
  const DrawnTerrain expected = draw_terrain(gpu, patient, from_far());
  CHECK(last.depth_m == expected.depth_m);
  CHECK(last.normal == expected.normal);
  // Nothing of a draft stays where all is asked for.
  CHECK(draw_terrain(gpu, terrain, from_far()).depth_m == expected.depth_m);
}

TEST_CASE("gpu: the first picture does not wait for a source that hangs") {
  GpuFixture gpu;
  Gate gate;
  TerrainSources sources;
  const auto hanging = ramp(512);
  sources.imagery = {hanging};
  sources.caches = {.memory = std::make_shared<HostBudget>(256u << 20), .disk = nullptr, .timeout_s = 0.0};
  hanging->before = [&](uint32_t, uint32_t, uint32_t, uint64_t) {
    gate.pass();
    return true;
  };
  Terrain painted(gpu.device, std::move(sources), {});
  const DrawnTerrain first = draw_terrain(gpu, painted, from_far(), kAtOnce);
  CHECK(is_whole(first));
  CHECK(painted.stats().tiles_missing > 0);
  gate.open();
  const DrawnTerrain last = finished(gpu, painted);
  CHECK(last.albedo != first.albedo);
  CHECK(draw_terrain(gpu, painted, from_far()).albedo == last.albedo);
}
