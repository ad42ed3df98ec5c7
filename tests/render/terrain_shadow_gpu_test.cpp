#include "io/array_raster.h"
#include "render/reference_scene.h"

namespace nepho {
namespace {
using namespace test;

constexpr double kGround_m = 100.0, kWall_m = 1100.0, kWallFrom_deg = 20.1;

/// Level ground, not the sea, with a wall 5 km thick along a meridian, on the equator.
TerrainSources wall() {
  RasterInfo info;
  info.path = "test";
  info.width = 2000;
  info.height = 100;
  info.bounds = {.west_deg = 19.8, .south_deg = -0.1, .east_deg = 20.3, .north_deg = 0.1};
  info.vertical = VerticalDatum::ellipsoid;
  std::vector<float> heights;
  for (uint32_t y = 0; y < info.height; ++y)
    for (uint32_t x = 0; x < info.width; ++x) {
      const double lon = 19.8 + 0.5 * (x + 0.5) / info.width;
      heights.push_back(static_cast<float>(lon > kWallFrom_deg && lon < kWallFrom_deg + 0.045 ? kWall_m : kGround_m));
    }
  TerrainSources sources;
  sources.elevation.push_back(std::make_shared<ArrayRaster>(info, std::move(heights)));
  return sources;
}

ImageBuffer picture_of(GpuFixture& gpu, bool shadows) {
  Scene scene;
  scene.time = "2026-03-20T05:10:00Z";  // the sun in the east, 6 degrees high
  scene.camera.lat_deg = 0.0;
  scene.camera.lon_deg = 20.03;  // 8 km west of the wall; the picture is 12 km wide
  scene.camera.height_m = 12e3;
  scene.camera.pitch_deg = -90.0;
  scene.camera.fov_deg = 5.0;
  scene.clouds.coverage = 0.0;
  scene.atmosphere.spectral = "fast";
  scene.atmosphere.scattering_orders = 2;
  scene.terrain.default_earth = false;
  scene.terrain.shadows = shadows;
  scene.render.width = 96;
  scene.render.height = 8;
  Renderer renderer(gpu.device, wall(), scene);
  RenderRequest request;
  request.display = false;
  return std::move(renderer.render(request).layers);
}

TEST_CASE(
    "gpu: ground behind a wall is dark at sunrise, ground further off is not, and the scene's switch is a switch") {
  GpuFixture gpu;
  const ImageBuffer shaded = picture_of(gpu, true), lit = picture_of(gpu, false);
  const std::vector<float>&share = channel(shaded, "surface.shadow"), &with = channel(shaded, "G"),
        &without = channel(lit, "G"), &mask = channel(lit, "surface.mask");
  size_t dark = 0, bright = 0, partly = 0;
  double dark_with = 0.0, dark_without = 0.0;
  for (size_t i = 0; i < share.size(); ++i) {
    REQUIRE(mask[i] == 1.0f);
    CHECK(channel(lit, "surface.shadow")[i] == 1.0f);
    if (share[i] == 0.0f) {
      ++dark;
      dark_with += static_cast<double>(with[i]);
      dark_without += static_cast<double>(without[i]);
    } else if (share[i] == 1.0f) {
      ++bright;
      CHECK(with[i] == without[i]);
    } else {
      ++partly;
      CHECK(with[i] < without[i]);
    }
  }
  CHECK(dark_with < 0.8 * dark_without);  // sky and air stay
  CHECK(dark > share.size() / 4);
  CHECK(bright > share.size() / 4);
  CHECK(partly > 0);
}

}  // namespace
}  // namespace nepho
