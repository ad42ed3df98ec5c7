#include <algorithm>

#include "render/reference_scene.h"

namespace nepho {
namespace {
using namespace test;

/// A small picture from above the clouds, the horizon in it.
Scene view_from_above(const CloudParams& clouds) {
  Scene scene = reference_scene(clouds, {48, 32});
  scene.time = "2026-06-21T02:00:00Z";  // about noon
  scene.camera.height_m = 9000.0;
  scene.camera.pitch_deg = -20.0;
  scene.clouds.multiple_scattering = "octaves";  // cheap
  scene.render.quality = "high";
  scene.clouds.multiple_scattering = "octaves";
  scene.render.frames = 1;
  return scene;
}

ImageBuffer layers_of(GpuFixture& gpu, const Scene& scene) {
  Renderer renderer(gpu.device, {}, scene);
  RenderRequest request;
  request.display = false;
  return std::move(renderer.render(request).layers);
}

double mean_of(const std::vector<float>& values, const std::vector<float>& mask) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < values.size(); ++i)
    if (mask[i] > 0.5f) {
      sum += static_cast<double>(values[i]);
      count += 1.0;
    }
  REQUIRE(count > 100.0);
  return sum / count;
}

TEST_CASE("gpu: surface.shadow is the share of sunlight under the clouds: 1 in the sky and without casters") {
  GpuFixture gpu;
  const Scene broken = view_from_above(half_sky("cumulus"));
  const ImageBuffer picture = layers_of(gpu, broken);
  const std::vector<float>& shadow = channel(picture, "surface.shadow");
  const std::vector<float>& sun = channel(picture, "sun.transmittance");
  const std::vector<float>& mask = channel(picture, "surface.mask");
  const std::vector<float>& through = channel(picture, "cloud.transmittance");
  size_t sky = 0, tops = 0;
  for (size_t i = 0; i < shadow.size(); ++i) {
    CHECK((shadow[i] >= 0.0f && shadow[i] <= 1.0f));
    CHECK((sun[i] >= 0.0f && sun[i] <= 1.0f));
    if (mask[i] < 0.5f) {
      ++sky;
      CHECK(shadow[i] == 1.0f);
    }
    if (through[i] >= 0.5f) CHECK(sun[i] == shadow[i]);
    if (through[i] < 0.5f && sun[i] > shadow[i]) ++tops;
  }
  CHECK(sky > 50);
  CHECK(tops > 50);  // tops of clouds are brighter than the ground below them
  // Half the sky is covered, and the sun stands high.
  const double lit = mean_of(shadow, mask);
  CHECK(lit > 0.3);
  CHECK(lit < 0.75);

  Scene without = broken;
  without.clouds.layers[0].casts_shadow = false;
  const ImageBuffer uncast = layers_of(gpu, without);
  for (const float s : channel(uncast, "surface.shadow")) CHECK(s == 1.0f);
  Scene clear = broken;
  clear.clouds.coverage = 0.0;
  const ImageBuffer bare = layers_of(gpu, clear);
  for (const float s : channel(bare, "surface.shadow")) CHECK(s == 1.0f);
  for (const float s : channel(bare, "sun.transmittance")) CHECK(s == 1.0f);
}

TEST_CASE("gpu: an overcast of stratus leaves the ground nearly without sunlight") {
  GpuFixture gpu;
  const ImageBuffer picture = layers_of(gpu, view_from_above(half_sky("stratus", 1.0)));
  CHECK(mean_of(channel(picture, "surface.shadow"), channel(picture, "surface.mask")) < 0.15);
}

}  // namespace
}  // namespace nepho
