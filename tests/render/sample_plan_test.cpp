#include "render/sample_plan.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

using namespace nepho;
using shared::PixelSums;

namespace {

/// Sums of `paths` paths of grey light with a mean of 1 and this variance of one path.
PixelSums pilot_of(float variance, float paths = 64.0f) {
  PixelSums s{};
  s.paths = paths;
  s.mean = glm::vec3(1.0f);
  s.squares = glm::vec3(variance * (paths - 1.0f));
  s.y_squares = variance * (paths - 1.0f);
  return s;
}

/// Plays a plan from a level to another in rounds and checks what every round may do; returns the paths of each pixel.
std::vector<uint64_t> play(const SamplePlan& plan, size_t pixels, double from, double to, uint64_t most_paths,
                           uint32_t most_samples) {
  std::vector<uint64_t> sum(pixels, 0);
  std::vector<uint32_t> samples;
  int rounds = 0;
  for (double level = from; level < to;) {
    const double reached = plan.round(level, to, most_paths, most_samples, samples);
    REQUIRE(reached > level);
    CHECK(reached <= to);
    REQUIRE(samples.size() == pixels);
    uint64_t all = 0;
    for (size_t i = 0; i < pixels; ++i) {
      CHECK(samples[i] <= most_samples + 1);  // a whole path more where the level cuts one
      all += samples[i];
      sum[i] += samples[i];
    }
    CHECK(all <= most_paths);
    CHECK(all == plan.paths(reached) - plan.paths(level));
    level = reached;
    REQUIRE(++rounds < 10000);
  }
  return sum;
}

}  // namespace

TEST_CASE("an even plan gives every pixel as many paths as its level says, in rounds within their limits") {
  const SamplePlan plan = SamplePlan::even(100);
  CHECK(plan.is_even());
  CHECK(plan.at(7, 24.0) == 24);
  CHECK(plan.paths(24.0) == 2400);
  for (const uint64_t n : play(plan, 100, 0.0, 1000.0, 30000, 128)) CHECK(n == 1000);
  for (const uint64_t n : play(plan, 100, 24.0, 77.0, 700, 128)) CHECK(n == 53);
}

TEST_CASE(
    "the levels at which noise is looked at are fixed: 16, then a fifth more each time; tenths of a plan by need") {
  const SamplePlan even = SamplePlan::even(4);
  std::vector<double> levels;
  for (double level = 0.0; levels.size() < 8;) levels.push_back(level = even.next_check(level));
  CHECK(levels == std::vector<double>{16, 20, 24, 29, 35, 42, 51, 62});
  const std::vector<PixelSums> pilot(4, pilot_of(1.0f));
  const SamplePlan by_need = SamplePlan::by_need(pilot, {2, 2}, 0.02);
  CHECK(by_need.next_check(0.0) == 0.5);
  CHECK(by_need.next_check(0.5) == doctest::Approx(0.6));
  CHECK(by_need.next_check(0.9) == doctest::Approx(1.0));
}

TEST_CASE("a plan by need gives variance over the square of 0.95 of the noise, within 32 and a million") {
  for (const float variance : {0.04f, 1.0f, 25.0f})
    for (const double noise : {0.04, 0.02, 0.01}) {
      CAPTURE(variance);
      CAPTURE(noise);
      const std::vector<PixelSums> pilot(6, pilot_of(variance));
      const SamplePlan plan = SamplePlan::by_need(pilot, {3, 2}, noise);
      CHECK_FALSE(plan.is_even());
      const double needed = std::max(static_cast<double>(variance) / std::pow(0.95 * noise, 2.0), 32.0);
      for (size_t i = 0; i < 6; ++i) {
        // A whole number of paths; the sums are float.
        CHECK(plan.at(i, 1.0) >= needed * (1.0 - 1e-5));
        CHECK(plan.at(i, 1.0) <= needed * (1.0 + 1e-5) + 1.0);
      }
    }
  const std::vector<PixelSums> wild(1, pilot_of(1e9f)), black(1, PixelSums{});
  CHECK(SamplePlan::by_need(wild, {1, 1}, 0.01).at(0, 1.0) == 1000000);
  CHECK(SamplePlan::by_need(black, {1, 1}, 0.01).at(0, 1.0) == 32);
}

TEST_CASE("a pixel's need is partly its own and partly its neighbours': a pilot that saw nothing there proves little") {
  std::vector<PixelSums> pilot(121, pilot_of(0.0f));
  pilot[60] = pilot_of(90.0f);  // the middle of 11 x 11
  const SamplePlan plan = SamplePlan::by_need(pilot, {11, 11}, 0.1);
  const double alone = 90.0 / (0.095 * 0.095);
  CHECK(plan.at(60, 1.0) < 0.9 * alone);
  CHECK(plan.at(60, 1.0) > 0.2 * alone);
  for (const size_t beside : {48u, 49u, 50u, 59u, 61u, 70u, 71u, 72u}) {
    CHECK(plan.at(beside, 1.0) > plan.at(0, 1.0));
    CHECK(plan.at(beside, 1.0) < plan.at(60, 1.0));
  }
  CHECK(plan.at(0, 1.0) == plan.at(55, 1.0));  // far away: the fewest
  CHECK(plan.at(0, 1.0) >= 32);
}

TEST_CASE("rounds of a plan by need add up to it, within their limits") {
  std::vector<PixelSums> pilot;
  for (int i = 0; i < 48; ++i) pilot.push_back(pilot_of(0.01f * static_cast<float>((i * 37) % 100)));
  const SamplePlan plan = SamplePlan::by_need(pilot, {8, 6}, 0.02);
  const std::vector<uint64_t> at_one = play(plan, 48, 0.0, 1.0, 20000, 128), on = play(plan, 48, 0.5, 1.3, 5000, 64);
  for (size_t i = 0; i < 48; ++i) {
    CHECK(at_one[i] == plan.at(i, 1.0));
    CHECK(on[i] == plan.at(i, 1.3) - plan.at(i, 0.5));
  }
  CHECK(std::accumulate(at_one.begin(), at_one.end(), uint64_t{0}) == plan.paths(1.0));
}

TEST_CASE("a plan like a picture's is even where that is, else in proportion to its paths") {
  std::vector<PixelSums> earlier(3, pilot_of(1.0f, 40.0f));
  CHECK(SamplePlan::like(earlier).is_even());
  earlier[1].paths = 100.0f;
  earlier[2].paths = 0.0f;
  const SamplePlan plan = SamplePlan::like(earlier);
  CHECK_FALSE(plan.is_even());
  CHECK(plan.at(0, 1.0) == 40);
  CHECK(plan.at(1, 1.0) == 100);
  CHECK(plan.at(2, 1.0) == 1);
  CHECK(plan.at(0, 1.5) == 60);
  CHECK(plan.at(1, 1.5) == 150);
}
