// Light inside clouds against the path tracer's pictures of tests/images, small: docs/accuracy.md has the whole table.
#include <cmath>
#include <filesystem>

#include "gpu/gpu_fixture.h"
#include "io/exr.h"
#include "render/renderer.h"
#include "scene/scene_json.h"

using namespace nepho;

namespace {

double luminance(const ImageBuffer& image, size_t pixel) {
  return 0.2126 * static_cast<double>(image.find("R")->values[pixel]) +
         0.7152 * static_cast<double>(image.find("G")->values[pixel]) +
         0.0722 * static_cast<double>(image.find("B")->values[pixel]);
}

struct Errors {
  double mean = 0.0, bias = 0.0;
};

/// A light scene drawn at a quarter of its width, against the means of the reference's pixels, where those hold clouds.
Errors errors_of(gpu::Device& device, const std::string& name, const std::string& method) {
  const std::filesystem::path root = NEPHO_SOURCE_DIR;
  Scene scene = load_scene(root / "data" / "scenes" / (name + ".json"));
  const ExrFile reference = read_exr(root / "tests" / "images" / (name + ".reference.exr"));
  constexpr uint32_t kShare = 4;
  scene.render.width = reference.image.width / kShare;
  scene.render.height = reference.image.height / kShare;
  scene.render.quality = "medium";
  scene.clouds.multiple_scattering = method;
  scene.shafts.method = "none";  // the reference's air knows no shadows
  Renderer renderer(device, {.bare_albedo = scene.imagery.bare_albedo}, scene);
  const RenderResult drawn = renderer.render({.display = false});
  double sum = 0.0, apart = 0.0, over = 0.0;
  for (uint32_t y = 0; y < scene.render.height; ++y)
    for (uint32_t x = 0; x < scene.render.width; ++x) {
      double truth = 0.0, clear = 0.0;
      for (uint32_t k = 0; k < kShare * kShare; ++k) {
        const size_t at = size_t{y * kShare + k / kShare} * reference.image.width + x * kShare + k % kShare;
        truth += luminance(reference.image, at) / (kShare * kShare);
        clear += static_cast<double>(reference.image.find("cloud.transmittance")->values[at]) / (kShare * kShare);
      }
      if (clear > 0.99) continue;
      const double mine = luminance(drawn.layers, size_t{y} * scene.render.width + x);
      sum += truth;
      apart += std::abs(mine - truth);
      over += mine - truth;
    }
  REQUIRE(sum > 0.0);
  return {apart / sum, over / sum};
}

}  // namespace

TEST_CASE("gpu: light in cumulus and under an overcast is near the path tracer's, and nearer than octaves") {
  GpuFixture f;
  for (const char* name : {"cumulus_sun60", "overcast_from_below"}) {
    CAPTURE(name);
    const Errors cells = errors_of(f.device, name, "cells"), octaves = errors_of(f.device, name, "octaves");
    MESSAGE(name, ": cells ", 100.0 * cells.mean, " %, bias ", 100.0 * cells.bias, " %; octaves ", 100.0 * octaves.mean,
            " %, bias ", 100.0 * octaves.bias, " %");
    CHECK(cells.mean < 0.16);
    CHECK(std::abs(cells.bias) < 0.09);
    CHECK(octaves.mean > 2.0 * cells.mean);
  }
}
