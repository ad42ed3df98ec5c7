#include <functional>

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

/// The wall at sunrise, the sun 6 degrees high in the east behind it, from a place and a height above the ellipsoid.
Scene by_the_wall(double lat_deg, double lon_deg, double height_m, double fov_deg, bool shadows) {
  Scene scene;
  scene.time = "2026-03-20T05:10:00Z";
  scene.camera.lat_deg = lat_deg;
  scene.camera.lon_deg = lon_deg;
  scene.camera.height_m = height_m;
  scene.camera.fov_deg = fov_deg;
  scene.clouds.coverage = 0.0;
  scene.atmosphere.spectral = "fast";
  scene.atmosphere.scattering_orders = 2;
  scene.terrain.default_earth = false;
  scene.terrain.shadows = shadows;
  return scene;
}

/// Seen along the wall from 4 km west of it, where its shadow is some 680 m high.
Scene along_wall(double height_m, bool shadows) {
  Scene scene = by_the_wall(-0.04, kWallFrom_deg - 0.036, height_m, 2.0, shadows);
  scene.camera.heading_deg = 0.0;
  scene.camera.pitch_deg = 0.0;
  scene.night_sky.stars = false;
  scene.render.width = 16;
  scene.render.height = 4;
  return scene;
}

/// Mean of a channel over the picture: with shadows of terrain per without.
double share_left(GpuFixture& gpu, double height_m, const char* name, const std::function<void(Scene&)>& change) {
  double sums[2];
  for (const bool shadows : {false, true}) {
    Scene scene = along_wall(height_m, shadows);
    change(scene);
    Renderer renderer(gpu.device, wall(), scene);
    RenderRequest request;
    request.display = false;
    const ImageBuffer layers = std::move(renderer.render(request).layers);
    double& sum = sums[shadows ? 1 : 0] = 0.0;
    for (const float value : channel(layers, name)) sum += static_cast<double>(value);
  }
  REQUIRE(sums[0] > 0.0);
  return sums[1] / sums[0];
}

ImageBuffer picture_of(GpuFixture& gpu, bool shadows) {
  Scene scene = by_the_wall(0.0, 20.03, 12e3, 5.0, shadows);  // 8 km west of the wall; the picture is 12 km wide
  scene.camera.pitch_deg = -90.0;
  scene.shafts.method = "none";  // air is another test's
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

TEST_CASE("gpu: from far beyond the Earth's size mountains take no light from the globe's air") {
  GpuFixture gpu;
  double sums[2];
  for (const bool shadows : {false, true}) {
    Scene scene = by_the_wall(0.0, 20.03, 40e6, 20.0, shadows);
    scene.time = "2026-03-20T08:40:00Z";  // the sun 60 degrees high; blocks of 2 x 2 pixels, 300 km wide
    scene.camera.pitch_deg = -90.0;
    scene.shafts.method = "shadow-length";
    scene.render.width = 96;
    scene.render.height = 96;
    Renderer renderer(gpu.device, wall(), scene);
    RenderRequest request;
    request.display = false;
    const ImageBuffer layers = std::move(renderer.render(request).layers);
    double& sum = sums[shadows ? 1 : 0] = 0.0;
    for (const float value : channel(layers, "B")) sum += static_cast<double>(value);
  }
  CHECK(sums[1] == doctest::Approx(sums[0]).epsilon(0.01));
}

TEST_CASE("gpu: haze behind a wall is dark below its shadow's edge and lit above it, by each method of shafts") {
  GpuFixture gpu;
  for (const std::string method : {"shadow-length", "froxel"}) {
    CAPTURE(method);
    const auto hazy = [&](Scene& scene) {
      scene.haze.layers = {{.extinction_per_m = 4e-4, .base_m = 1500.0, .scale_height_m = 20.0, .phase_g = 0.5}};
      scene.shafts.method = method;
    };
    const double below = share_left(gpu, 350.0, "G", hazy), above = share_left(gpu, 1000.0, "G", hazy);
    MESSAGE(method, ": light left below ", below, ", above ", above);
    CHECK(below < 0.75);
    CHECK(above > 0.97);
    CHECK(above < 1.005);
  }
}

TEST_CASE(
    "gpu: air alone sends less light where a wall shades it, and clear air without terrain's shadows is untouched") {
  GpuFixture gpu;
  const auto method = [](const char* name) { return [name](Scene& scene) { scene.shafts.method = name; }; };
  CHECK(share_left(gpu, 350.0, "G", method("shadow-length")) < 0.99);
  CHECK(share_left(gpu, 350.0, "G", method("none")) == 1.0);
}

TEST_CASE("gpu: cloud behind a wall gets no sunlight below its shadow's edge and all of it above, octaves and cells") {
  GpuFixture gpu;
  for (const std::string quality : {"low", "medium"}) {
    CAPTURE(quality);
    const auto cloudy = [&](Scene& scene, double base_m) {
      CloudLayer layer;
      layer.base_m = base_m;
      layer.thickness_m = 150.0;
      scene.clouds.coverage = 1.0;
      scene.clouds.layers = {layer};
      scene.clouds.uniform_density = 0.5;
      scene.render.quality = quality;
      scene.shafts.method = "none";
    };
    const double below = share_left(gpu, 300.0, "cloud.G", [&](Scene& scene) { cloudy(scene, 250.0); });
    const double above = share_left(gpu, 1000.0, "cloud.G", [&](Scene& scene) { cloudy(scene, 950.0); });
    MESSAGE(quality, ": light left below ", below, ", above ", above);
    CHECK(below <
          (quality == "low" ? 0.72 : 0.85));  // the sky's light stays; in cells that of sunlit cloud near by, too
    CHECK(above > 0.95);
    CHECK(above < 1.02);
  }
}

}  // namespace
}  // namespace nepho
