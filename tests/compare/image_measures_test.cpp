#include "compare/image_measures.h"

#include <doctest/doctest.h>

#include <cmath>

#include "compare/heatmap.h"

using namespace nepho;
using Rgb = std::vector<glm::vec3>;

namespace {
const PixelMask kFour = {1, 1, 1, 1};
}

TEST_CASE("rmse, mean relative error and bias of four pixels by hand") {
  const std::vector<double> a = {11.0, 18.0, 30.0, 44.0}, b = {10.0, 20.0, 30.0, 40.0};
  const LinearMeasures all = linear_measures(a, b, kFour);
  CHECK(all.rmse == doctest::Approx(std::sqrt((1.0 + 4.0 + 0.0 + 16.0) / 4.0)));
  CHECK(*all.mean_relative_error == doctest::Approx(7.0 / 100.0));
  CHECK(*all.bias == doctest::Approx(3.0 / 100.0));
  const LinearMeasures some = linear_measures(a, b, {0, 1, 1, 0});
  CHECK(some.rmse == doctest::Approx(std::sqrt(2.0)));
  CHECK(*some.mean_relative_error == doctest::Approx(2.0 / 50.0));
  CHECK(*some.bias == doctest::Approx(-2.0 / 50.0));
}

TEST_CASE("against a black reference there is no relative error") {
  const LinearMeasures m = linear_measures(std::vector{1.0}, std::vector{0.0}, {1});
  CHECK(m.rmse == 1.0);
  CHECK_FALSE(m.mean_relative_error.has_value());
  CHECK_FALSE(m.bias.has_value());
}

TEST_CASE("psnr: 0.1 in every channel is 20 dB, in one of three 20 + 10 log10 3; equal pictures have none") {
  const Rgb grey(4, glm::vec3(0.5f));
  CHECK(*psnr_db(Rgb(4, glm::vec3(0.6f)), grey, kFour) == doctest::Approx(20.0).epsilon(1e-6));
  const Rgb red(4, glm::vec3(0.6f, 0.5f, 0.5f));
  CHECK(*psnr_db(red, grey, kFour) == doctest::Approx(20.0 + 10.0 * std::log10(3.0)).epsilon(1e-6));
  Rgb one = grey;
  one[2] = glm::vec3(0.6f);
  CHECK(*psnr_db(one, grey, kFour) == doctest::Approx(20.0 + 10.0 * std::log10(4.0)).epsilon(1e-6));
  CHECK_FALSE(psnr_db(one, grey, {1, 1, 0, 1}).has_value());
}

TEST_CASE("ssim: equal pictures have 1, constants the luminance term alone, small pictures none") {
  const PixelMask all(16 * 16, 1);
  Rgb waves;
  for (int i = 0; i < 256; ++i) waves.push_back(glm::vec3(0.5f + 0.4f * std::sin(static_cast<float>(i))));
  CHECK(*ssim(16, 16, waves, waves, all) == 1.0);
  // Constants have no variance: (2 a b + C1) / (a^2 + b^2 + C1), C1 = 1e-4. The weights of luma sum to 1.
  const double expected = (2.0 * 0.4 * 0.6 + 1e-4) / (0.16 + 0.36 + 1e-4);
  CHECK(*ssim(16, 16, Rgb(256, glm::vec3(0.4f)), Rgb(256, glm::vec3(0.6f)), all) ==
        doctest::Approx(expected).epsilon(1e-5));
  CHECK_FALSE(ssim(10, 16, Rgb(160), Rgb(160), PixelMask(160, 1)).has_value());
}

TEST_CASE("ssim: a black and white board against its inverse has the covariance term -1 nearly") {
  // Means are 1/2 in both but for what the window leaves, variances 1/4, covariance -1/4: luminance 1, and
  // (-1/2 + C2) / (1/2 + C2), C2 = 9e-4.
  Rgb board, inverse;
  for (uint32_t y = 0; y < 20; ++y)
    for (uint32_t x = 0; x < 20; ++x) {
      board.push_back(glm::vec3((x + y) % 2 == 0 ? 1.0f : 0.0f));
      inverse.push_back(glm::vec3(1.0f) - board.back());
    }
  CHECK(*ssim(20, 20, board, inverse, PixelMask(400, 1)) ==
        doctest::Approx((-0.5 + 9e-4) / (0.5 + 9e-4)).epsilon(1e-4));
}

TEST_CASE("ssim: two waves agree with a sum over the 121 weights of every window, over the mask alone") {
  constexpr uint32_t kWidth = 15, kHeight = 13;
  Rgb a, b;
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      a.emplace_back(0.5 + 0.3 * std::sin(0.9 * x + 0.3 * y));
      b.emplace_back(0.45 + 0.25 * std::sin(0.9 * x + 0.3 * y + 0.4));
    }
  // tests/compare/measures_by_definition.py prints it: weighted sums of squares of differences, in double precision.
  CHECK(*ssim(kWidth, kHeight, a, b, PixelMask(a.size(), 1)) == doctest::Approx(0.899076541).epsilon(1e-5));
  PixelMask edge(a.size(), 0);
  edge[0] = edge[4 * kWidth + 7] = 1;  // windows that reach beyond the picture
  CHECK_FALSE(ssim(kWidth, kHeight, a, b, edge).has_value());
}

TEST_CASE("noise: standard errors of the channels add, relative to luminance, 95th percentile by nearest rank") {
  const auto deviations = [](float r, float g, float b) { return glm::vec3(r * r, g * g, b * b); };
  const std::vector<double> y = {10.0};
  CHECK(*relative_noise(y, Rgb{deviations(1.0f, 2.0f, 3.0f)}, {1}) ==
        doctest::Approx((0.2126 * 1.0 + 0.7152 * 2.0 + 0.0722 * 3.0) / 10.0).epsilon(1e-6));
  // 100 pixels with relative errors of 1 to 100 %: 95 of them have at most 95 %.
  Rgb variance;
  for (int i = 1; i <= 100; ++i) variance.push_back(deviations(1, 1, 1) * static_cast<float>(i * i) * 1e-4f);
  std::vector<double> ones(100, 1.0);
  PixelMask mask(100, 1);
  CHECK(*relative_noise(ones, variance, mask) == doctest::Approx(0.95).epsilon(1e-5));
  for (size_t i = 20; i < 100; ++i) mask[i] = 0;
  CHECK(*relative_noise(ones, variance, mask) == doctest::Approx(0.19).epsilon(1e-5));
}

TEST_CASE("noise: black without variance has none; too many black pixels with variance have no finite one") {
  CHECK(*relative_noise(std::vector{0.0}, Rgb{glm::vec3(0.0f)}, {1}) == 0.0);
  CHECK_FALSE(relative_noise(std::vector{0.0}, Rgb{glm::vec3(1.0f)}, {1}).has_value());
}

TEST_CASE("heatmap: blue is too dark, red too bright, near white equal, full at half, grey outside of the mask") {
  using Colour = std::array<uint8_t, 3>;
  CHECK(error_colour(-0.5) == Colour{5, 48, 97});
  CHECK(error_colour(-7.0) == Colour{5, 48, 97});
  CHECK(error_colour(0.0) == Colour{247, 247, 247});
  CHECK(error_colour(0.5) == Colour{103, 0, 31});
  CHECK(error_colour(0.05) == Colour{250, 233, 223});  // half way to the next stop
  // Mean of B over the mask is 10: the error of the second pixel is 5.25 / (10 + 0.5) = 0.5.
  const std::vector<double> a = {10.0, 15.25, 3.0}, b = {10.0, 10.0, 99.0};
  CHECK(error_heatmap(a, b, {1, 1, 0}) == std::vector<uint8_t>{247, 247, 247, 103, 0, 31, 128, 128, 128});
  CHECK(error_heatmap(std::vector{1.0, 0.0}, std::vector{0.0, 0.0}, {1, 1}) ==
        std::vector<uint8_t>{103, 0, 31, 247, 247, 247});
}

TEST_CASE("agreement: Z by hand, pixels without variance must be equal") {
  const std::vector<double> a{10.0, 10.0, 5.0, 5.0}, b{13.0, 10.5, 5.0, 6.0};
  // One channel's deviation: 1 / 0.7152 of green gives a standard error of 1 in luminance.
  const float v = 1.0f / (0.7152f * 0.7152f);
  const std::vector<glm::vec3> va{{0, v, 0}, {0, v, 0}, {0, 0, 0}, {0, 0, 0}}, vb(4, glm::vec3(0.0f));
  const Agreement three = agreement(a, b, va, vb, {1, 1, 1, 0});
  CHECK(three.largest_z == doctest::Approx(3.0).epsilon(1e-5));
  CHECK(agreement(a, b, va, vb, {0, 1, 1, 1}).within_3_sigma == doctest::Approx(2.0 / 3.0));
  CHECK(agreement(a, b, va, va, {1, 0, 0, 0}).largest_z == doctest::Approx(3.0 / std::sqrt(2.0)).epsilon(1e-5));
}
