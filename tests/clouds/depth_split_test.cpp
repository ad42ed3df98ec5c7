#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "clouds/depth_split.h"

using namespace nepho;
using shared::DepthSplit;

namespace {

struct Sheet {
  float distance_m, opacity;
};

glm::vec4 sums_of(const std::vector<Sheet>& sheets, float first_m) {
  glm::vec4 sums(0.0f);
  for (const Sheet& s : sheets) {
    const float x = shared::split_place(s.distance_m, first_m);
    sums += s.opacity * glm::vec4(1.0f, x, x * x, x * x * x);
  }
  return sums;
}

double mean_transmittance(const std::vector<Sheet>& sheets, double per_m) {
  double sum = 0.0, all = 0.0;
  for (const Sheet& s : sheets) {
    sum += static_cast<double>(s.opacity) * std::exp(-per_m * static_cast<double>(s.distance_m));
    all += static_cast<double>(s.opacity);
  }
  return sum / all;
}

double split_transmittance(const DepthSplit& split, float first_m, double per_m) {
  const auto through = [&](float x) {
    return std::exp(-per_m * static_cast<double>(shared::split_distance(x, first_m)));
  };
  const double near = static_cast<double>(split.near_share);
  return near * through(split.near_x) + (1.0 - near) * through(split.far_x);
}

}  // namespace

TEST_CASE("two sheets of cloud are found again, from fog at the eye to clouds seen from orbit") {
  for (const std::vector<Sheet>& sheets : {std::vector<Sheet>{{3.0f, 0.3f}, {12e3f, 0.7f}},
                                           {{800.0f, 0.02f}, {900.0f, 0.97f}},
                                           {{10e3f, 0.5f}, {80e3f, 0.001f}},
                                           {{400e3f, 0.2f}, {409e3f, 0.8f}}}) {
    CAPTURE(sheets[0].distance_m);
    const float first_m = sheets[0].distance_m;
    const DepthSplit split = shared::split_depths(sums_of(sheets, first_m));
    CHECK(shared::split_distance(split.near_x, first_m) == doctest::Approx(sheets[0].distance_m).epsilon(2e-3));
    CHECK(shared::split_distance(split.far_x, first_m) == doctest::Approx(sheets[1].distance_m).epsilon(2e-3));
    CHECK(split.near_share ==
          doctest::Approx(sheets[0].opacity / (sheets[0].opacity + sheets[1].opacity)).epsilon(4e-3));
    // Light of the first sheet alone goes to the first alone.
    const float x = shared::split_place(sheets[0].distance_m, first_m);
    CHECK(shared::split_near_part(split, 5.0f, 5.0f * x) == doctest::Approx(5.0).epsilon(2e-3));
    CHECK(std::abs(shared::split_near_part(split, 5.0f, 5.0f * split.far_x)) < 0.01f);
  }
}

TEST_CASE("one sheet has one depth") {
  const DepthSplit split = shared::split_depths(sums_of({{5e3f, 0.4f}, {5e3f, 0.2f}}, 5e3f));
  CHECK(split.near_x == split.far_x);
  CHECK(shared::split_distance(split.far_x, 5e3f) == doctest::Approx(5e3));
  CHECK(shared::split_near_part(split, 1.0f, 0.0f) == 0.0f);
}

TEST_CASE(
    "two depths keep the sums of powers up to the third, and mean transmittance 30 times better than the mean depth") {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  double worst = 0.0, error = 0.0, error_of_mean = 0.0;
  for (int k = 0; k < 400; ++k) {
    // A thin cloud, some way behind it a thick one that the ray enters by some hundred metres.
    std::vector<Sheet> sheets;
    const float near_m = 200.0f + 5e3f * unit(random), far_m = near_m + 2e4f * unit(random);
    for (int i = 0; i < 8; ++i) sheets.push_back({near_m + 50.0f * static_cast<float>(i), 0.08f * unit(random)});
    for (int i = 0; i < 30; ++i)
      sheets.push_back({far_m + 20.0f * static_cast<float>(i), 0.2f * std::exp(-0.2f * static_cast<float>(i))});
    const float first_m = sheets[0].distance_m;
    const glm::vec4 sums = sums_of(sheets, first_m);
    const DepthSplit split = shared::split_depths(sums);
    REQUIRE(split.near_x >= 0.0f);
    REQUIRE(split.far_x >= split.near_x);
    for (int power = 0; power < 4; ++power) {
      const float kept = split.near_share * std::pow(split.near_x, static_cast<float>(power)) +
                         (1.0f - split.near_share) * std::pow(split.far_x, static_cast<float>(power));
      CHECK(kept * sums.x == doctest::Approx(sums[power]).epsilon(2e-3));
    }
    double mean_m = 0.0, all = 0.0;
    for (const Sheet& s : sheets) {
      mean_m += static_cast<double>(s.distance_m) * static_cast<double>(s.opacity);
      all += static_cast<double>(s.opacity);
    }
    const double per_m = 1e-4, truth = mean_transmittance(sheets, per_m);
    const double off = std::abs(split_transmittance(split, first_m, per_m) / truth - 1.0);
    worst = std::max(worst, off);
    error += off;
    error_of_mean += std::abs(std::exp(-per_m * mean_m / all) / truth - 1.0);
  }
  CAPTURE(worst);
  CHECK(worst < 0.01);
  CHECK(error_of_mean > 30.0 * error);
}
