#include "common/random.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "statistics.h"

using namespace nepho;
using namespace nepho::test;
using shared::Random;
using shared::random_stream;
using shared::random_unit;

namespace {

constexpr size_t kSide = 16;

size_t bin_of(float u, size_t bins) { return static_cast<size_t>(u * static_cast<float>(bins)); }

/// Two streams' numbers against each other: sigmas of the histogram of pairs, and of the correlation.
struct Pairs {
  std::vector<double> counts = std::vector<double>(kSide * kSide, 0.0);
  double n = 0.0, product = 0.0;
  void add(float a, float b) {
    counts[bin_of(a, kSide) * kSide + bin_of(b, kSide)] += 1.0;
    n += 1.0;
    product += (static_cast<double>(a) - 0.5) * (static_cast<double>(b) - 0.5);
  }
  double histogram_sigmas() const {
    return chi_square_sigmas(counts, std::vector<double>(counts.size(), n / static_cast<double>(counts.size())));
  }
  /// The product of two independent uniform numbers about their means has the variance 1 / 144.
  double correlation_sigmas() const { return product / std::sqrt(n) * 12.0; }
};

}  // namespace

TEST_CASE("random numbers are in [0, 1), even, with the mean and variance of the uniform distribution") {
  for (const uint32_t seed : {0u, 1u, 0xffffffffu}) {
    CAPTURE(seed);
    Random r = random_stream(0u, 0u, seed);
    Moments m;
    std::vector<double> counts(1024, 0.0);
    for (int i = 0; i < 1 << 20; ++i) {
      const float u = random_unit(r);
      REQUIRE(u >= 0.0f);
      REQUIRE(u < 1.0f);
      counts[bin_of(u, counts.size())] += 1.0;
      m.add(static_cast<double>(u));
    }
    CHECK(std::abs(m.mean() - 0.5) < 4.0 * m.error());
    // The variance of (u - 1/2)^2 is 1 / 180.
    CHECK(std::abs(m.variance() - 1.0 / 12.0) < 4.0 * std::sqrt(1.0 / 180.0 / m.n));
    CHECK(std::abs(chi_square_sigmas(counts, std::vector<double>(counts.size(), 1024.0))) < 4.0);
  }
}

TEST_CASE("the largest random number is below 1") {
  CHECK(static_cast<float>(0xffffffffu >> 8u) * (1.0f / 16777216.0f) < 1.0f);
  Random r = random_stream(3u, 4u, 5u);
  float largest = 0.0f;
  for (int i = 0; i < 1 << 21; ++i) largest = std::max(largest, random_unit(r));
  CHECK(largest > 0.9999f);
  CHECK(largest < 1.0f);
}

TEST_CASE("successive numbers of a stream are independent") {
  for (const uint32_t lag : {1u, 2u, 3u, 8u}) {
    CAPTURE(lag);
    Pairs pairs;
    for (uint32_t pixel = 0; pixel < 4096; ++pixel) {
      Random r = random_stream(pixel, 17u, 1u);
      float u[72];
      for (float& v : u) v = random_unit(r);
      for (uint32_t i = 0; i < 64; ++i) pairs.add(u[i], u[i + lag]);
    }
    CHECK(std::abs(pairs.histogram_sigmas()) < 4.0);
    CHECK(std::abs(pairs.correlation_sigmas()) < 4.0);
  }
}

TEST_CASE("streams of neighbouring pixels, rows, samples and seeds are independent, number by number") {
  struct Step {
    uint32_t pixel, sample, seed;
  };
  for (const Step step : {Step{1, 0, 0}, {1920, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1u << 16u, 0, 0}})
    for (const uint32_t skip : {0u, 1u, 7u, 40u}) {
      CAPTURE(step.pixel);
      CAPTURE(step.sample);
      CAPTURE(step.seed);
      CAPTURE(skip);
      Pairs pairs;
      for (uint32_t i = 0; i < 65536; ++i) {
        // Along pixels where samples step, and so on.
        Random a = random_stream(i, i / 256, 7u);
        Random b = random_stream(i + step.pixel, i / 256 + step.sample, 7u + step.seed);
        for (uint32_t k = 0; k < skip; ++k) {
          random_unit(a);
          random_unit(b);
        }
        pairs.add(random_unit(a), random_unit(b));
      }
      CHECK(std::abs(pairs.histogram_sigmas()) < 4.0);
      CHECK(std::abs(pairs.correlation_sigmas()) < 4.0);
    }
}

TEST_CASE("the first numbers of all samples of one pixel are even, and of all pixels of one sample") {
  for (const uint32_t skip : {0u, 1u, 5u}) {
    std::vector<double> samples(256, 0.0), pixels(256, 0.0);
    for (uint32_t i = 0; i < 65536; ++i) {
      Random a = random_stream(12345u, i, 1u), b = random_stream(i, 0u, 1u);
      for (uint32_t k = 0; k < skip; ++k) {
        random_unit(a);
        random_unit(b);
      }
      samples[bin_of(random_unit(a), 256)] += 1.0;
      pixels[bin_of(random_unit(b), 256)] += 1.0;
    }
    const std::vector<double> expected(256, 256.0);
    CHECK(std::abs(chi_square_sigmas(samples, expected)) < 4.0);
    CHECK(std::abs(chi_square_sigmas(pixels, expected)) < 4.0);
  }
}

TEST_CASE("every bit of a number depends on every bit of pixel, sample and seed") {
  // Flipping one bit of what is hashed flips each bit of the first number in half of all cases.
  constexpr int kTrials = 2048;
  double worst = 0.0;
  for (int in = 0; in < 96; ++in) {
    std::vector<double> flips(24, 0.0);
    for (uint32_t t = 0; t < kTrials; ++t) {
      shared::uvec3 v(t * 2654435761u, t, t * 97u), w = v;
      w[in / 32] ^= 1u << (in % 32);
      Random a = random_stream(v.x, v.y, v.z), b = random_stream(w.x, w.y, w.z);
      const uint32_t flipped = (shared::random_next(a) ^ shared::random_next(b)) >> 8u;
      for (size_t bit = 0; bit < 24; ++bit) flips[bit] += static_cast<double>((flipped >> bit) & 1u);
    }
    for (const double f : flips) worst = std::max(worst, std::abs(f - kTrials / 2.0) / std::sqrt(kTrials / 4.0));
  }
  CAPTURE(worst);
  CHECK(worst < 5.0);
}

TEST_CASE("no two of a million streams start alike in state and increment") {
  std::vector<uint64_t> starts;
  for (uint32_t pixel = 0; pixel < 1024; ++pixel)
    for (uint32_t sample = 0; sample < 1024; ++sample) {
      const Random r = random_stream(pixel, sample, 1u);
      REQUIRE((r.increment & 1u) == 1u);
      starts.push_back((uint64_t{r.state} << 32u) | r.increment);
    }
  std::sort(starts.begin(), starts.end());
  CHECK(std::adjacent_find(starts.begin(), starts.end()) == starts.end());
}
