// Haze as drawn, where closed forms know it.
#include <cmath>

#include "render/reference_scene.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// A clear sky over bare ground, with these layers.
Scene hazy_scene(double height_m, double pitch_deg, const std::vector<HazeLayer>& layers) {
  Scene scene = reference_scene(cloud_sky("clear").value(), {32, 18});
  scene.time = "2026-06-21T02:30:00Z";
  scene.camera.height_m = height_m;
  scene.camera.heading_deg = 0.0;
  scene.camera.pitch_deg = pitch_deg;
  scene.camera.fov_deg = 1.0;
  scene.terrain.screen_error_px = 0.05;  // or the mesh of the ground may lie below the ground
  scene.render.quality = "high";
  scene.render.frames = 1;
  scene.haze.layers = layers;
  return scene;
}

ImageBuffer draw(gpu::Device& device, const Scene& scene) {
  Renderer renderer(device, {}, scene);
  RenderRequest request;
  request.display = false;
  return std::move(renderer.render(request).layers);
}

double centre(const ImageBuffer& image, const char* name) {
  return static_cast<double>(channel(image, name)[size_t{image.height / 2} * image.width + image.width / 2]);
}

}  // namespace

TEST_CASE("gpu: a low layer that only absorbs dims the sky above it by exp(-depth / sin(elevation)), within 1 %") {
  GpuFixture gpu;
  const HazeLayer soot{.extinction_per_m = 0.02, .base_m = 20.0, .scale_height_m = 10.0, .albedo = 0.0};
  for (const double elevation_deg : {90.0, 30.0, 12.0}) {
    const ImageBuffer clear = draw(gpu.device, hazy_scene(0.5, elevation_deg, {}));
    const ImageBuffer hazy = draw(gpu.device, hazy_scene(0.5, elevation_deg, {soot}));
    // The row below the picture's middle, as the pixel's centre: half a pixel lower.
    const double at = rad_from_deg(elevation_deg - 0.5 * 1.0 / 18.0);
    const double expected = std::exp(-0.02 * (19.5 + 10.0) / std::sin(at));
    CHECK(centre(hazy, "G") / centre(clear, "G") == doctest::Approx(expected).epsilon(0.01));
  }
}

TEST_CASE(
    "gpu: a layer of haze dims and brightens the ground as much seen from 1 km as from 400 km, but for the air "
    "between") {
  GpuFixture gpu;
  for (const double albedo : {0.0, 1.0}) {
    const HazeLayer haze{.extinction_per_m = 0.01, .base_m = 60.0, .scale_height_m = 20.0, .albedo = albedo};
    double added[2], clear_at[2];
    int i = 0;
    for (const double height_m : {1000.0, 400e3}) {
      const ImageBuffer clear = draw(gpu.device, hazy_scene(height_m, -90.0, {}));
      const ImageBuffer hazy = draw(gpu.device, hazy_scene(height_m, -90.0, {haze}));
      clear_at[i] = centre(clear, "R");
      added[i++] = centre(hazy, "R") - centre(clear, "R");
    }
    // The air above a kilometre lets 95 % of red light through, straight up. White haze adds a fifth of the light at
    // most, as the difference of what it takes and gives.
    CHECK(added[1] / added[0] == doctest::Approx(0.951).epsilon(albedo > 0.5 ? 0.04 : 0.01));
    // Soot of depth 0.8 takes exp(-0.8) down to the eye and more on the way in; white haze darkens ground of albedo 0.2
    // no further than to three quarters, as it sends light back itself.
    CHECK(added[0] / clear_at[0] ==
          (albedo > 0.5 ? doctest::Approx(0.0).epsilon(0.3) : doctest::Approx(-0.8).epsilon(0.1)));
  }
}

TEST_CASE(
    "gpu: within deep white fog all directions but the sun's side are alike, and as bright as half the sun and sky "
    "that come in") {
  GpuFixture gpu;
  // Vertical depth 20: what reaches the ground has forgotten where it came from. Albedo of the ground 0: nothing but
  // fog.
  const HazeLayer fog{.extinction_per_m = 0.05, .base_m = 400.0, .scale_height_m = 1.0, .albedo = 1.0, .phase_g = 0.0};
  Scene scene = hazy_scene(390.0, 0.0, {fog});
  scene.atmosphere.ground_albedo = 0.0;
  const double level = centre(draw(gpu.device, scene), "G");
  scene.camera.heading_deg = 180.0;
  CHECK(centre(draw(gpu.device, scene), "G") == doctest::Approx(level).epsilon(0.1));
  // Straight down from over it: a conservative slab of depth 20 sends back 94 % of the light (1 - 4 / (4 + 60)), bare
  // ground 20 %.
  scene.camera.height_m = 2000.0;
  scene.camera.pitch_deg = -90.0;
  const double above = centre(draw(gpu.device, scene), "G");
  scene.haze.layers.clear();
  const double ground = centre(draw(gpu.device, scene), "G");
  CHECK(above / ground == doctest::Approx(0.94 / 0.2).epsilon(0.1));
}

TEST_CASE("gpu: haze that is disabled, or has no layers, leaves every bit of the picture as it is") {
  GpuFixture gpu;
  Scene scene = hazy_scene(100.0, 0.0, {HazeLayer{}});
  scene.haze.enabled = false;
  CHECK(channel(draw(gpu.device, scene), "G") == channel(draw(gpu.device, hazy_scene(100.0, 0.0, {})), "G"));
}
