#include "compare/compare_images.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "io/file_test_tools.h"

using namespace nepho;
using test::message_of;

namespace {

constexpr uint32_t kWidth = 32, kHeight = 20;
constexpr size_t kCount = size_t{kWidth} * kHeight;

/// A picture of one luminance, cd/m2.
ImageBuffer plain(float value) {
  ImageBuffer image{.width = kWidth, .height = kHeight, .channels = {}};
  for (const char* name : {"B", "G", "R"}) image.channels.push_back({name, std::vector<float>(kCount, value)});
  return image;
}

void add(ImageBuffer& image, const std::string& name, float value) {
  image.channels.push_back({name, std::vector<float>(kCount, value)});
}

std::vector<float>& channel(ImageBuffer& image, const std::string& name) {
  for (ImageChannel& c : image.channels)
    if (c.name == name) return c.values;
  throw std::out_of_range(name);
}

std::string input_error(const ImageBuffer& a, const ImageBuffer& b, const CompareOptions& options = {}) {
  return message_of([&] { compare_images(a, b, options); }, ErrorKind::input);
}

}  // namespace

TEST_CASE("a picture against itself: no error in any measure") {
  const Comparison same = compare_images(plain(300.0f), plain(300.0f), {});
  CHECK(same.rmse == 0.0);
  CHECK(same.mean_relative_error == 0.0);
  CHECK(same.bias == 0.0);
  CHECK_FALSE(same.psnr_db.has_value());
  CHECK(same.ssim == 1.0);
  CHECK(same.flip == 0.0);
  CHECK(same.pixels == kCount);
  CHECK_FALSE(same.noise_of_b.has_value());
  CHECK(same.heatmap_rgb.empty());
}

TEST_CASE("a picture a tenth brighter than its reference, by closed forms") {
  // Both are plain; with the curve `linear` and white at 1.2 * 2^10 cd/m2 = 1228.8, B shows 0.25 and A 0.275.
  const float level = 0.25f * 1228.8f;
  const CompareOptions options{.exposure_ev100 = 10.0, .tone_curve = tone_curve_id("linear")};
  const Comparison c = compare_images(plain(1.1f * level), plain(level), options);
  CHECK(c.rmse == doctest::Approx(0.1 * 307.2).epsilon(1e-5));
  CHECK(*c.mean_relative_error == doctest::Approx(0.1).epsilon(1e-5));
  CHECK(*c.bias == doctest::Approx(0.1).epsilon(1e-5));
  const auto srgb = [](double v) { return 1.055 * std::pow(v, 1.0 / 2.4) - 0.055; };
  const double a = srgb(0.275), b = srgb(0.25);
  CHECK(*c.psnr_db == doctest::Approx(-20.0 * std::log10(a - b)).epsilon(1e-4));
  CHECK(*c.ssim == doctest::Approx((2 * a * b + 1e-4) / (a * a + b * b + 1e-4)).epsilon(1e-5));
  // Greys of relative luminance 0.25 and 0.275: L* by CIE, then FLIP's formula of colours.
  const double lightness = 116.0 * (std::cbrt(0.275) - std::cbrt(0.25));
  CHECK(c.flip == doctest::Approx(0.95 / (0.4 * 41.2761) * std::pow(lightness, 0.7)).epsilon(1e-3));
  CHECK(c.exposure_ev100 == 10.0);
}

TEST_CASE("exposure and white balance are those of B, and the same for both") {
  const Comparison c = compare_images(plain(5.0f), plain(4000.0f), {.tone_curve = tone_curve_id("agx")});
  const std::vector<glm::vec3> b(kCount, glm::vec3(4000.0f));
  CHECK(c.exposure_ev100 == metered_ev100(kWidth, kHeight, b));
  // White balance halves what is shown of both: the same as half the light.
  const CompareOptions options{.exposure_ev100 = 12.0, .tone_curve = tone_curve_id("linear")};
  CompareOptions halved = options;
  halved.white_balance = 0.5f * glm::mat3(1.0f);
  CHECK(*compare_images(plain(900.0f), plain(800.0f), halved).psnr_db ==
        doctest::Approx(*compare_images(plain(450.0f), plain(400.0f), options).psnr_db).epsilon(1e-5));
}

TEST_CASE("mask cloud: pixels whose transmittance in B is below 0.99 count, and no others") {
  ImageBuffer a = plain(100.0f), b = plain(100.0f);
  add(b, "cloud.transmittance", 0.99f);
  std::vector<float>& transmittance = channel(b, "cloud.transmittance");
  for (size_t y = 0; y < kHeight; ++y)
    for (size_t x = 0; x < kWidth / 2; ++x) {
      transmittance[y * kWidth + x] = 0.98f;
      for (const char* name : {"R", "G", "B"}) channel(a, name)[y * kWidth + x] = 150.0f;
    }
  const Comparison cloud = compare_images(a, b, {.mask = CompareMask::cloud, .heatmap = true});
  CHECK(cloud.pixels == kCount / 2);
  CHECK(*cloud.mean_relative_error == doctest::Approx(0.5).epsilon(1e-6));
  CHECK(cloud.rmse == doctest::Approx(50.0).epsilon(1e-6));
  const Comparison all = compare_images(a, b, {});
  CHECK(all.pixels == kCount);
  CHECK(*all.mean_relative_error == doctest::Approx(0.25).epsilon(1e-6));
  CHECK(*all.psnr_db - *cloud.psnr_db == doctest::Approx(10.0 * std::log10(2.0)).epsilon(1e-4));
  CHECK(*all.ssim > *cloud.ssim);
  CHECK(all.flip < cloud.flip);
  CHECK(cloud.heatmap_rgb.size() == 3 * kCount);
  CHECK(cloud.heatmap_rgb[3 * kWidth - 1] == 128);  // the right end of the first row is outside
  CHECK(cloud.heatmap_rgb[2] < 100);                // 50 / 105 too bright: red
}

TEST_CASE("noise of B comes from its variance layers") {
  ImageBuffer b = plain(200.0f);
  for (const char* name : {"variance.R", "variance.G", "variance.B"}) add(b, name, 16.0f);
  CHECK(*compare_images(plain(200.0f), b, {}).noise_of_b == doctest::Approx(4.0 / 200.0).epsilon(1e-6));
  channel(b, "variance.G")[7] = -1.0f;
  CHECK(input_error(plain(200.0f), b, {.name_b = "b.exr"}) ==
        "b.exr: 1 values of variance.R/G/B are negative, NaN or infinite; render it again");
}

TEST_CASE("pictures that cannot be compared are input errors that name the picture and what was found") {
  const CompareOptions options{.name_a = "a.exr", .name_b = "b.exr"};
  ImageBuffer small{.width = 2, .height = 1, .channels = {}};
  for (const char* name : {"B", "G", "R"}) small.channels.push_back({name, {1.0f, 2.0f}});
  CHECK(input_error(small, plain(1.0f), options) ==
        "a.exr has 2x1 pixels and b.exr 32x20; only pictures of one size can be compared");

  ImageBuffer grey{.width = kWidth, .height = kHeight, .channels = {}};
  add(grey, "Y", 1.0f);
  CHECK(input_error(grey, plain(1.0f), options) ==
        "a.exr: has no channels R, G, B (found: Y); compare pictures that nepho render wrote");

  ImageBuffer broken = plain(1.0f);
  channel(broken, "G")[3] = std::numeric_limits<float>::quiet_NaN();
  channel(broken, "B")[3] = channel(broken, "B")[9] = std::numeric_limits<float>::infinity();
  CHECK(input_error(plain(1.0f), broken, options) ==
        "b.exr: 2 of 640 pixels are NaN or infinite in R, G or B; nothing can be measured with them");

  CompareOptions cloud = options;
  cloud.mask = CompareMask::cloud;
  ImageBuffer b = plain(1.0f);
  CHECK(input_error(b, b, cloud).starts_with("b.exr: has no layer cloud.transmittance, which --mask cloud needs"));
  add(b, "cloud.transmittance", 1.0f);
  CHECK(input_error(b, b, cloud) == "b.exr: no pixel has cloud (cloud.transmittance < 0.99); leave --mask cloud out");
}

TEST_CASE("luminances of float's whole range, and pictures of one pixel, give finite measures") {
  ImageBuffer a = plain(3.0e38f), b = plain(1.0e-30f);
  for (const char* curve : {"agx", "aces", "reinhard", "linear"}) {
    const Comparison c = compare_images(a, b, {.exposure_ev100 = -8.0, .tone_curve = tone_curve_id(curve)});
    CHECK(std::isfinite(c.rmse));
    CHECK(std::isfinite(*c.psnr_db));
    CHECK(std::isfinite(*c.ssim));
    CHECK(c.flip > 0.9);
  }
  ImageBuffer one{.width = 1, .height = 1, .channels = {}};
  for (const char* name : {"B", "G", "R"}) one.channels.push_back({name, {7.0f}});
  const Comparison c = compare_images(one, one, {});
  CHECK(c.pixels == 1);
  CHECK_FALSE(c.ssim.has_value());
  CHECK(c.flip == 0.0);
}
