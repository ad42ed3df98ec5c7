#include "clouds/blue_noise.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

using namespace nepho;

namespace {

using Complex = std::complex<double>;
constexpr size_t kSide = kBlueSize, kSlice = kSide * kSide;

const std::vector<uint8_t>& blue() {
  static const std::vector<uint8_t> noise = make_blue_noise();
  return noise;
}

/// Fourier transform of n numbers `stride` apart.
std::vector<Complex> transform(const Complex* values, size_t n, size_t stride) {
  std::vector<Complex> sums(n);
  for (size_t k = 0; k < n; ++k)
    for (size_t i = 0; i < n; ++i)
      sums[k] += values[i * stride] *
                 std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(i * k % n) / static_cast<double>(n));
  return sums;
}

/// Power over the plane, as a multiple of white noise of the same variance, in rings of the frequency (cycles a side).
std::array<double, 46> ring_power(size_t slice) {
  std::vector<Complex> plane(kSlice);
  double variance = 0.0;
  for (size_t i = 0; i < kSlice; ++i) {
    plane[i] = blue()[slice * kSlice + i] - 127.5;
    variance += std::norm(plane[i]) / kSlice;
  }
  for (size_t y = 0; y < kSide; ++y) {
    const auto row = transform(&plane[y * kSide], kSide, 1);
    std::copy(row.begin(), row.end(), &plane[y * kSide]);
  }
  std::array<double, 46> power{}, count{};
  for (size_t x = 0; x < kSide; ++x) {
    const auto column = transform(&plane[x], kSide, kSide);
    for (size_t y = 0; y < kSide; ++y) {
      const auto fx = static_cast<double>(std::min(x, kSide - x)), fy = static_cast<double>(std::min(y, kSide - y));
      const auto ring = static_cast<size_t>(std::lround(std::hypot(fx, fy)));
      power[ring] += std::norm(column[y]) / (kSlice * variance);
      count[ring] += 1.0;
    }
  }
  for (size_t r = 0; r < power.size(); ++r) power[r] /= std::max(count[r], 1.0);
  return power;
}

}  // namespace

TEST_CASE("blue noise: every slice holds each of 0..255 equally often") {
  REQUIRE(blue().size() == kSlice * kBlueSlices);
  for (size_t slice = 0; slice < kBlueSlices; ++slice) {
    std::array<int, 256> count{};
    for (size_t i = 0; i < kSlice; ++i) ++count[blue()[slice * kSlice + i]];
    for (const int n : count) CHECK(n == kSlice / 256);
  }
}

TEST_CASE("blue noise: the low frequencies of a slice are nearly empty, the high ones fuller than white noise") {
  double lowest = 0.0, low = 0.0, high = 0.0;
  for (size_t slice = 0; slice < kBlueSlices; ++slice) {
    const auto power = ring_power(slice);
    double slice_low = 0.0;
    for (size_t r = 1; r <= 4; ++r) lowest += power[r] / 4.0 / kBlueSlices;
    for (size_t r = 1; r <= 10; ++r) slice_low += power[r] / 10.0;
    CHECK(slice_low < 0.02);
    low += slice_low / kBlueSlices;
    for (size_t r = 26; r <= 32; ++r) high += power[r] / 7.0 / kBlueSlices;
  }
  MESSAGE("power of rings 1-4: ", lowest, ", 1-10: ", low, ", 26-32: ", high, " of white noise");
  CHECK(lowest < 0.003);
  CHECK(high > 1.15);
}

TEST_CASE("blue noise: a pixel's values from slice to slice lack low frequencies too") {
  std::array<double, kBlueSlices> power{};
  double variance = 0.0;
  for (size_t i = 0; i < kSlice; ++i) {
    std::array<Complex, kBlueSlices> series;
    for (size_t t = 0; t < kBlueSlices; ++t) {
      series[t] = blue()[t * kSlice + i] - 127.5;
      variance += std::norm(series[t]) / static_cast<double>(kBlueSlices * kSlice);
    }
    const auto spectrum = transform(series.data(), kBlueSlices, 1);
    for (size_t k = 0; k < kBlueSlices; ++k)
      power[k] += std::norm(spectrum[k]) / static_cast<double>(kBlueSlices * kSlice);
  }
  for (double& p : power) p /= variance;
  MESSAGE("power of 0, 1, 2, 4, 8 cycles: ", power[0], " ", power[1], " ", power[2], " ", power[4], " ", power[8]);
  CHECK(power[0] < 0.05);
  CHECK(power[1] < 0.1);
  CHECK(power[2] < 0.25);
  CHECK(power[8] > 1.3);
}

TEST_CASE("blue noise: neighbouring slices differ as much as chance would have them") {
  double product = 0.0;
  for (size_t i = 0; i < kSlice * (kBlueSlices - 1); ++i) product += (blue()[i] - 127.5) * (blue()[i + kSlice] - 127.5);
  const double correlation = product / static_cast<double>(kSlice * (kBlueSlices - 1)) / (256.0 * 256.0 / 12.0);
  CHECK(correlation < 0.0);  // blue in time: the next value tends to lie on the other side
  CHECK(correlation > -0.5);
}

TEST_CASE("blue noise: ranks leave what is uniform as it is, and equal values equal") {
  std::vector<float> values(blue().begin(), blue().end());
  std::vector<uint8_t> ranks;
  REQUIRE(equalise_slices(values, ranks));
  CHECK(ranks == blue());
  for (float& v : values) v = v < 64.0f ? 3.0f : 9.0f;  // a quarter, three quarters
  REQUIRE(equalise_slices(values, ranks));
  for (size_t i = 0; i < ranks.size(); ++i) CHECK(ranks[i] == (blue()[i] < 64 ? 32 : 160));
  std::fill(values.begin(), values.end(), 5.0f);
  CHECK_FALSE(equalise_slices(values, ranks));
}
