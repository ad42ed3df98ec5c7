#include <set>

#include "gpu/gpu_fixture.h"
#include "render/debug_views.h"
#include "render/renderer.h"

namespace nepho {
namespace {

TEST_CASE(
    "gpu: every debug view draws clouds in several colours, each view its own picture; unknown names are refused") {
  GpuFixture gpu;
  Scene scene;
  scene.clouds.multiple_scattering = "octaves";  // how light scatters does not matter
  scene.render.width = 48;
  scene.render.height = 32;
  scene.camera.height_m = 6000.0;
  scene.camera.pitch_deg = -20.0;
  scene.clouds = cloud_sky("fair").value();
  for (CloudLayer& layer : scene.clouds.layers) layer.base_reference = "ellipsoid";
  Renderer renderer(gpu.device, {}, scene);
  std::set<std::vector<uint8_t>> pictures;
  for (const std::string& view : known_debug_views()) {
    const RenderResult drawn = renderer.render({.display = true, .layers = false, .wanted = {}, .debug = view});
    std::set<std::array<uint8_t, 3>> colors;
    for (size_t i = 0; i + 2 < drawn.display_rgb.size(); i += 3)
      colors.insert({drawn.display_rgb[i], drawn.display_rgb[i + 1], drawn.display_rgb[i + 2]});
    CAPTURE(view);
    CHECK(drawn.display_rgb.size() == 48 * 32 * 3);
    CHECK(colors.size() > 1);
    pictures.insert(drawn.display_rgb);
  }
  CHECK(pictures.size() == known_debug_views().size());
  CHECK_THROWS_AS(renderer.render({.display = true, .layers = false, .wanted = {}, .debug = "wheather"}), Error);
}

}  // namespace
}  // namespace nepho
