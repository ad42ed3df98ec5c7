#include <cmath>
#include <functional>
#include <vector>

#include "common/tonemap.h"
#include "gpu/gpu_fixture.h"
#include "render/exposure_passes.h"
#include "tone/tone.h"

namespace nepho {
namespace {

constexpr Extent2D kSize{512, 256};
using Fill = std::function<glm::vec3(uint32_t x, uint32_t y)>;

struct Shot {
  double ev100 = 0.0;
  std::vector<uint8_t> rgba;
};

struct ExposureFixture : GpuFixture {
  ExposureFixture() : passes(device) {}
  ExposurePasses passes;

  Shot shoot(const Fill& fill, const RenderParams& params = {}, double frame_interval_s = 0.0) {
    std::vector<float> texels;
    for (uint32_t y = 0; y < kSize.height; ++y)
      for (uint32_t x = 0; x < kSize.width; ++x) {
        const glm::vec3 v = fill(x, y);
        texels.insert(texels.end(), {v.r, v.g, v.b, 1.0f});
      }
    const gpu::Image image = device.create_image({.name = "scene", .extent = kSize, .format = Format::rgba32f});
    const gpu::ImageUpload upload{&image, std::as_bytes(std::span(texels))};
    device.upload({&upload, 1});
    FrameGraph graph;
    const ExposurePasses::Outputs out = passes.add(graph, graph.import(image), params, frame_interval_s);
    graph.keep(out.display);
    graph.keep(out.state);
    executor.run(graph);
    return {static_cast<double>(executor.read<float>(out.state)[0]), executor.read<uint8_t>(out.display)};
  }
};

/// Evenly lit scene of this luminance.
Fill plain(float luminance) {
  return [luminance](uint32_t, uint32_t) { return glm::vec3(luminance); };
}

/// EV100 of an evenly lit scene: all of it is its brightest part, at 0.9 of saturation; darker by night, closed form.
double expected_ev100(double luminance) {
  const double metered = std::log2(luminance / 1.2) - std::log2(0.9);
  const double middle_grey = 0.18 * 1.2 * std::exp2(metered);
  return metered + 4.5 / (1.0 + std::pow(middle_grey / 0.01, 0.7));
}

constexpr double kBin = 55.0 / 256.0;  // stops

}  // namespace

TEST_CASE_FIXTURE(ExposureFixture,
                  "exposure: plain scenes meter as the closed form says, from noon to a moonless night") {
  RenderParams params;
  params.min_ev100 = -20.0;
  for (const float l : {1.0e4f, 300.0f, 1.0f, 0.01f, 2.0e-4f, 1.0e-6f})
    CHECK(std::abs(shoot(plain(l), params).ev100 - expected_ev100(static_cast<double>(l))) <
          kBin + 0.01);  // a percentile lies anywhere in its bin
}

TEST_CASE_FIXTURE(ExposureFixture, "exposure: black space, its stars and the sun's disc do not count") {
  const double alone = shoot(plain(2000.0f)).ev100;
  const double beside = shoot([](uint32_t x, uint32_t y) {
                          if (x < 300) return glm::vec3((x + y) % 7 == 0 ? 1.0e-4f : 0.0f);
                          return glm::vec3(x < 400 && y < 100 ? 1.0e9f : 2000.0f);
                        }).ev100;
  CHECK(beside == doctest::Approx(alone).epsilon(1e-3));
}

TEST_CASE_FIXTURE(ExposureFixture, "exposure: the moon's disc and stars leave the night's exposure alone") {
  const double alone = shoot(plain(5.0e-3f)).ev100;
  const double beside = shoot([](uint32_t x, uint32_t y) {
                          const float dx = static_cast<float>(x) - 200.0f, dy = static_cast<float>(y) - 80.0f;
                          if (dx * dx + dy * dy < 12.0f * 12.0f) return glm::vec3(2500.0f);
                          return glm::vec3((x * 37 + y * 101) % 499 == 0 ? 0.5f : 5.0e-3f);
                        }).ev100;
  CHECK(std::abs(beside - alone) < 0.1);
}

TEST_CASE_FIXTURE(ExposureFixture,
                  "exposure: compensation makes brighter, limits hold, a fixed value is used as it is") {
  RenderParams params;
  const double plain_ev = shoot(plain(500.0f), params).ev100;
  params.exposure_compensation_ev = 1.5;
  CHECK(shoot(plain(500.0f), params).ev100 == doctest::Approx(plain_ev - 1.5).epsilon(1e-5));
  params.exposure_compensation_ev = 0.0;
  params.min_ev100 = 12.0;
  params.max_ev100 = 13.0;
  CHECK(shoot(plain(5.0f), params).ev100 == 12.0);
  CHECK(shoot(plain(1.0e5f), params).ev100 == 13.0);
  CHECK(shoot(plain(0.0f), params).ev100 == 12.0);  // nothing to meter
  params.exposure_ev100 = 9.25;
  params.exposure_compensation_ev = 3.0;
  CHECK(shoot(plain(500.0f), params).ev100 == 9.25);
}

TEST_CASE_FIXTURE(ExposureFixture, "exposure: the meter on the CPU shows what the meter on the GPU shows") {
  for (const float level : {1.0e-3f, 50.0f, 4.0e4f}) {
    const Fill fill = [level](uint32_t x, uint32_t y) {
      const float stops = 0.02f * static_cast<float>((x * 7919u + y * 104729u) % 1021u) - 10.0f;
      return glm::vec3(0.6f, 1.0f, 1.4f) * level * std::exp2(stops);
    };
    std::vector<glm::vec3> rgb;
    for (uint32_t y = 0; y < kSize.height; ++y)
      for (uint32_t x = 0; x < kSize.width; ++x) rgb.push_back(fill(x, y));
    CHECK(metered_ev100(kSize.width, kSize.height, rgb) == doctest::Approx(shoot(fill).ev100).epsilon(1e-4));
  }
}

TEST_CASE_FIXTURE(ExposureFixture, "exposure: adapts by 1 - exp(-dt / tau) in sequences and at once in stills") {
  RenderParams params;
  params.exposure_adaptation_s = 2.0;
  const double bright = shoot(plain(4000.0f), params, 0.5).ev100;  // the first picture has nothing to come from
  CHECK(std::abs(bright - expected_ev100(4000.0)) < kBin + 0.01);  // a percentile lies anywhere in its bin
  const double dark_target = ExposureFixture().shoot(plain(40.0f), params).ev100;
  double expected = bright;
  for (int i = 0; i < 3; ++i) {
    expected = dark_target + (expected - dark_target) * std::exp(-0.5 / 2.0);
    CHECK(shoot(plain(40.0f), params, 0.5).ev100 == doctest::Approx(expected).epsilon(1e-4));
  }
  CHECK(shoot(plain(40.0f), params, 0.0).ev100 == doctest::Approx(dark_target).epsilon(1e-6));
}

TEST_CASE_FIXTURE(ExposureFixture, "tonemap: the 8-bit picture is the shared functions' own, in every curve") {
  RenderParams params;
  params.exposure_ev100 = 10.0;
  params.white_balance_k = 6504.0;
  params.seed = 3;
  const Fill fill = [](uint32_t x, uint32_t y) {
    const float fx = static_cast<float>(x) / 511.0f, fy = static_cast<float>(y) / 255.0f;
    return glm::vec3(fx, 0.7f * fx + 0.1f * fy, 0.5f * fy - 0.1f) * 3000.0f;
  };
  for (const auto& [name, curve] : {std::pair{"aces", shared::kToneAces},
                                    {"agx", shared::kToneAgx},
                                    {"reinhard", shared::kToneReinhard},
                                    {"linear", shared::kToneLinear}}) {
    CAPTURE(name);
    params.tone_curve = name;
    const Shot shot = shoot(fill, params);
    size_t different = 0;
    int worst = 0;
    for (uint32_t y = 0; y < kSize.height; ++y)
      for (uint32_t x = 0; x < kSize.width; ++x) {
        const glm::vec3 v = shared::display_from_exposed(fill(x, y) * shared::exposure_from_ev100(10.0f), curve);
        const uint32_t offset = 3u * 0x9e3779b9u;
        const uint32_t thirds[] = {0x55555555u, 0u, 0xaaaaaaaau};
        for (int c = 0; c < 3; ++c) {
          const float q = shared::quantise(v[c], shared::dither_pattern({x, y}, offset + thirds[c]));
          const int off =
              std::abs(static_cast<int>(q) - shot.rgba[4 * (y * kSize.width + x) + static_cast<uint32_t>(c)]);
          different += off != 0;
          worst = std::max(worst, off);
        }
      }
    CHECK(worst <= 1);  // the rounding of sqrt and log2 differs between devices
    CHECK(different < 3 * kSize.width * kSize.height * 5 / 1000);  // near half steps only
  }
}

TEST_CASE_FIXTURE(ExposureFixture, "tonemap: one seed, the same bits; another seed, other noise") {
  RenderParams params;
  const Fill fill = [](uint32_t x, uint32_t y) {
    return glm::vec3(800.0f + static_cast<float>(x) + 0.5f * static_cast<float>(y));
  };
  const Shot first = shoot(fill, params), again = shoot(fill, params);
  CHECK(first.rgba == again.rgba);
  CHECK(first.ev100 == again.ev100);
  params.seed = 1;
  CHECK(shoot(fill, params).rgba != first.rgba);
}

}  // namespace nepho
