// Quality reference in a white furnace.
#include <algorithm>

#include "render/reference_scene.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// A picture's green, and the variance of its mean.
struct Green {
  std::vector<float> mean, variance;
  explicit Green(const ImageBuffer& image) : mean(channel(image, "G")), variance(channel(image, "variance.G")) {}
};

struct Furnace {
  const char* name;
  CloudParams clouds;
  double height_m = 300.0, pitch_deg = 25.0;
};

CloudParams with_medium(CloudParams clouds, double scattering_per_m, double g_forward, double g_backward,
                        double backward_weight) {
  clouds.scattering_per_m = scattering_per_m;
  clouds.absorption_per_m = 0.0;
  clouds.phase_g_forward = g_forward;
  clouds.phase_g_backward = g_backward;
  clouds.phase_backward_weight = backward_weight;
  return clouds;
}

CloudParams slab(double thickness_m) {
  CloudParams clouds = half_sky("cumulus", 1.0);
  clouds.layers[0].thickness_m = thickness_m;
  clouds.uniform_density = 1.0;
  return clouds;
}

}  // namespace

TEST_CASE("gpu: white furnace: where light comes evenly from all sides, clouds that absorb nothing are not seen") {
  std::vector<Furnace> cases = {
      {"cumulus", with_medium(half_sky("cumulus"), 0.04, 0.85, -0.2, 0.1)},
      {"dense isotropic cumulus, from within", with_medium(half_sky("cumulus"), 0.2, 0.0, 0.0, 0.0), 2300.0, 0.0},
      {"thin backward slab", with_medium(slab(400.0), 0.01, -0.5, 0.0, 0.0)}};
  if (full_size()) {
    for (const double per_m : {0.01, 0.04, 0.2})
      for (const double g : {0.85, 0.0, -0.5}) {
        const double weight = g > 0.5 ? 0.1 : 0.0;
        cases.push_back({"cumulus", with_medium(half_sky("cumulus"), per_m, g, -0.2, weight)});
        cases.push_back({"slab", with_medium(slab(200.0), per_m, g, -0.2, weight), 4000.0, -50.0});
      }
  }
  for (const Furnace& c : cases) {
    CAPTURE(std::string(c.name));
    CAPTURE(c.clouds.scattering_per_m);
    CAPTURE(c.clouds.phase_g_forward);
    GpuFixture f;
    Scene scene = reference_scene(c.clouds, {16, 9}, 5);
    scene.camera.height_m = c.height_m;
    scene.camera.pitch_deg = c.pitch_deg;
    scene.render.furnace_cd_m2 = 1.0;
    scene.render.frames = 16;
    Renderer renderer(f.device, {}, scene);
    RenderRequest request;
    request.display = false;
    const Green picture(renderer.render(request).layers);
    double sum = 0.0, worst = 0.0, largest_error = 0.0;
    for (size_t i = 0; i < picture.mean.size(); ++i) {
      sum += static_cast<double>(picture.mean[i]);
      const double error = std::sqrt(static_cast<double>(picture.variance[i]));
      const double off = std::abs(static_cast<double>(picture.mean[i]) - 1.0);
      largest_error = std::max(largest_error, error);
      worst = std::max(worst, off);
      CHECK(off <= 4.0 * error + 1e-4);
    }
    const double mean = sum / static_cast<double>(picture.mean.size());
    const ReferenceCounts& counts = renderer.timings().reference;
    CHECK(std::abs(mean - 1.0) <= 0.005);
    CHECK(counts.paths == 16 * 16 * 9);
    CHECK(counts.vertices > counts.paths);  // there was cloud
    MESSAGE(std::string(c.name), " ", c.clouds.scattering_per_m, "/m g ", c.clouds.phase_g_forward, ": mean ", mean,
            ", worst pixel ", worst, ", largest standard error ", largest_error, ", vertices a path ",
            static_cast<double>(counts.vertices) / static_cast<double>(counts.paths), ", overruns ", counts.overruns);
  }
}
