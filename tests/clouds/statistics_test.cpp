#include "clouds/statistics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace nepho::test {
namespace {

/// White normal noise, smoothed forth and back along rows and columns: a lattice-free field whose spectrum falls
/// evenly. `keep`: what a pixel hands on to the next, along x and y; `passes` make it steeper.
Grid red_noise(size_t width, size_t height, uint32_t seed, double keep_x = 0.8, double keep_y = 0.8, int passes = 1) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  Grid g(width, height);
  for (double& v : g.values) v = normal(generator);
  for (int pass = 0; pass < passes; ++pass) {
    for (size_t y = 0; y < height; ++y) {
      for (size_t x = 1; x < width; ++x) g.at(x, y) += keep_x * g.at(x - 1, y);
      for (size_t x = width - 1; x-- > 0;) g.at(x, y) += keep_x * g.at(x + 1, y);
    }
    for (size_t x = 0; x < width; ++x) {
      for (size_t y = 1; y < height; ++y) g.at(x, y) += keep_y * g.at(x, y - 1);
      for (size_t y = height - 1; y-- > 0;) g.at(x, y) += keep_y * g.at(x, y + 1);
    }
  }
  return g;
}

double deviation(const Grid& g) {
  double sum = 0.0, square = 0.0;
  for (const double v : g.values) {
    sum += v;
    square += v * v;
  }
  const auto n = static_cast<double>(g.values.size());
  return std::sqrt(square / n - sum * sum / (n * n));
}

TEST_CASE("a wave's power lies at its cycles per window; the estimate is a mean over windows") {
  Grid g(128, 64);
  for (size_t y = 0; y < 64; ++y)
    for (size_t x = 0; x < 128; ++x)
      g.at(x, y) = std::cos(2.0 * M_PI * (5.0 * static_cast<double>(x) + 3.0 * static_cast<double>(y)) / 32.0);
  const Spectrum s = hann_spectrum(g, 32, 16);
  CHECK(s.windows == 7 * 3);
  CHECK(s.at(5, 3) == doctest::Approx(std::pow(0.5 * 16.0 * 16.0, 2)));  // amplitude / 2 times the sum of the windows
  CHECK(s.at(27, 29) == doctest::Approx(s.at(5, 3)));
  CHECK(s.at(10, 3) < 1e-9 * s.at(5, 3));
}

TEST_CASE("lattice-free noise has no ordinate above 2.2 times its neighbourhood in 81 windows, 1.7 in 225") {
  const Grid g = red_noise(1024, 1024, 3);
  const Spectrum fine = hann_spectrum(g, 128, 64), long_waves = hann_spectrum(g, 256, 96);
  CHECK(fine.windows == 225);
  CHECK(long_waves.windows == 81);
  const double a = highest_true_line(fine, 3.0).ratio, b = highest_true_line(long_waves, 3.0).ratio;
  MESSAGE("lattice-free: ", a, " of 225 windows, ", b, " of 81");
  CHECK(a < 1.7);
  CHECK(b < 2.2);
}

TEST_CASE("rows with 2 % of the variance of a red field are found at their frequency, square ones too") {
  for (const bool square : {false, true}) {
    Grid g = red_noise(1024, 1024, 3);
    const double amplitude = 0.2 * deviation(g);  // variance 0.2^2 / 2
    for (size_t y = 0; y < 1024; ++y)
      for (size_t x = 0; x < 1024; ++x) {
        const double u = (static_cast<double>(x) + 0.4 * static_cast<double>(y)) / 6.1;
        const double v = (static_cast<double>(y) - 0.4 * static_cast<double>(x)) / 6.1;
        g.at(x, y) +=
            amplitude * (square ? std::cos(2.0 * M_PI * u) * std::cos(2.0 * M_PI * v) : std::cos(2.0 * M_PI * u));
      }
    const LatticeLine line = highest_true_line(hann_spectrum(g, 128, 64), 3.0);
    CHECK(line.ratio > 3.0);
    if (!square) {
      CHECK(std::abs(std::abs(line.kx) - 21) <= 1);  // 128 / 6.1
      CHECK(std::abs(std::abs(line.ky) - 8) <= 1);
    }
  }
}

TEST_CASE(
    "prewhitening keeps steep and stretched lattice-free spectra below 2.2, where the raw ones exceed 3 near their "
    "middle") {
  for (const double keep_x : {0.9, 0.95}) {
    const Spectrum spectrum = hann_spectrum(red_noise(1024, 1024, 5, keep_x, 0.8, 2), 128, 64);
    const double flat = highest_true_line(spectrum, 3.0).ratio, raw = highest_line(spectrum, 3.0).ratio;
    MESSAGE("keep ", keep_x, ": raw ", raw, ", prewhitened ", flat);
    CHECK(raw > 3.0);
    CHECK(flat < 2.2);
  }
}

TEST_CASE("a field that repeats has a prominent summit at the period; one that does not, a trend or not, has none") {
  Grid once = red_noise(512, 512, 11), twice(512, 512);
  for (size_t y = 0; y < 512; ++y)
    for (size_t x = 0; x < 512; ++x) twice.at(x, y) = once.at(x % 150, y);
  const Summit repeated = most_prominent(autocorrelation(twice), 30.0);
  CHECK(repeated.prominence > 0.8);
  CHECK(std::abs(repeated.distance - 150.0) < 1.0);
  for (size_t y = 0; y < 512; ++y)
    for (size_t x = 0; x < 512; ++x) once.at(x, y) += 5.0 * static_cast<double>(x) - 3.0 * static_cast<double>(y);
  const Grid map = autocorrelation(once);
  CHECK(map.at(256, 256) == doctest::Approx(1.0));
  CHECK(most_prominent(map, 30.0).prominence < 0.15);
}

TEST_CASE("prominence is the height above the highest pass to higher ground") {
  Grid map(9, 5);
  for (double& v : map.values) v = -1.0;
  const double ridge[9] = {0.0, 1.0, 0.4, 0.2, 1.5, 0.6, 0.7, 0.1, 0.0};
  for (size_t x = 0; x < 9; ++x) map.at(x, 2) = ridge[x];
  CHECK(most_prominent(map, 1.0).prominence == doctest::Approx(0.8));  // 1.0 over the pass at 0.2
  CHECK(most_prominent(map, 1.0).distance == doctest::Approx(3.0));
  CHECK(most_prominent(map, 3.5).prominence == doctest::Approx(0.0));
}

TEST_CASE("percentiles, correlation and displacement are those of small known samples") {
  CHECK(percentile({5.0, 1.0, 3.0, 2.0, 4.0}, 0.5) == 3.0);
  CHECK(percentile({5.0, 1.0, 3.0, 2.0, 4.0}, 1.0) == 5.0);
  CHECK(correlation({1.0, 2.0, 3.0}, {2.0, 4.0, 6.0}) == doctest::Approx(1.0));
  CHECK(correlation({1.0, 2.0, 3.0, 4.0}, {1.0, -1.0, -1.0, 1.0}) == doctest::Approx(0.0));
  const Grid field = red_noise(200, 200, 2);
  Grid a(128, 128), b(128, 128);
  for (size_t y = 0; y < 128; ++y)
    for (size_t x = 0; x < 128; ++x) {
      a.at(x, y) = field.at(x + 30, y + 30);
      b.at(x, y) = field.at(x + 30 - 7, y + 30 + 4);  // seven to the right, four up
    }
  const Displacement d = displacement(a, b, 20);
  CHECK(std::abs(d.dx - 7.0) < 0.2);
  CHECK(std::abs(d.dy + 4.0) < 0.2);
  CHECK(d.peak > 0.9);
}

}  // namespace
}  // namespace nepho::test
