#include "compare/flip.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace nepho;

namespace {

constexpr uint32_t kWidth = 24, kHeight = 18;
using Rgb = std::vector<glm::vec3>;

Plane flip_of_constants(const glm::vec3& a, const glm::vec3& b) {
  return flip_map(kWidth, kHeight, Rgb(kWidth * kHeight, a), Rgb(kWidth * kHeight, b));
}

/// A picture with edges, lines and all hues; `changed` has a patch of another colour in it and less blue.
Rgb pattern(bool changed) {
  Rgb out;
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const double r = 0.5 + 0.4 * std::sin(0.9 * x + 0.3 * y), g = 0.5 + 0.3 * std::cos(0.4 * x - 0.7 * y);
      const double b = 0.1 + 0.8 * ((x * 7 + y * 5) % 11) / 10.0;
      const bool patch = changed && x >= 8 && x < 14 && y >= 5 && y < 11;
      out.emplace_back(patch ? std::min(r + 0.2, 1.0) : r, patch ? 0.6 * g : g, changed && !patch ? 0.9 * b : b);
    }
  return out;
}

}  // namespace

TEST_CASE("flip: the default viewer sees 67 pixels a degree") {
  CHECK(FlipView().pixels_per_degree() == doctest::Approx(67.0206).epsilon(1e-6));
}

TEST_CASE("flip: equal pictures differ by exactly 0") {
  const Rgb picture = pattern(false);
  for (const float v : flip_map(kWidth, kHeight, picture, picture).values) CHECK(v == 0.0f);
}

TEST_CASE("flip: green against blue is the largest difference, 1; black against white is 0.96738") {
  for (const float v : flip_of_constants({0, 1, 0}, {0, 0, 1}).values)
    CHECK(static_cast<double>(v) == doctest::Approx(1.0).epsilon(1e-5));
  // A constant picture has no features, so the formula of colours alone: HyAB is the difference of L*, 100. Green and
  // blue are 203.2 apart (L*a*b* after Hunt's adjustment), c_max = 41.2761 = 203.2^0.7, and 100^0.7 = 25.119 lies over
  // 0.4 c_max: 0.95 + 0.05 (25.119 - 16.510) / (41.276 - 16.510).
  for (const float v : flip_of_constants(glm::vec3(0), glm::vec3(1)).values)
    CHECK(static_cast<double>(v) == doctest::Approx(0.96738).epsilon(1e-5));
}

TEST_CASE("flip: a small difference of greys is 0.95 / (0.4 c_max) times the difference of L* to the power 0.7") {
  const auto lightness = [](double srgb) { return 116.0 * std::cbrt(std::pow((srgb + 0.055) / 1.055, 2.4)) - 16.0; };
  const double expected = 0.95 / (0.4 * 41.2761) * std::pow(lightness(0.6) - lightness(0.5), 0.7);
  for (const float v : flip_of_constants(glm::vec3(0.5f), glm::vec3(0.6f)).values)
    CHECK(static_cast<double>(v) == doctest::Approx(expected).epsilon(1e-4));
}

TEST_CASE("flip: symmetric, and within 0..1") {
  const Rgb a = pattern(true), b = pattern(false);
  const Plane there = flip_map(kWidth, kHeight, a, b), back = flip_map(kWidth, kHeight, b, a);
  CHECK(there.values == back.values);
  CHECK(*std::min_element(there.values.begin(), there.values.end()) > 0.0f);
  CHECK(*std::max_element(there.values.begin(), there.values.end()) < 1.0f);
}

TEST_CASE("flip: a pattern's map is that of the definition by two-dimensional filters") {
  // From tests/compare/measures_by_definition.py, which sums over whole two-dimensional kernels in double precision.
  const struct {
    uint32_t x, y;
    double flip;
  } expected[] = {{0, 0, 0.179444},   {8, 5, 0.588631},   {11, 8, 0.764689},
                  {14, 11, 0.183486}, {23, 17, 0.183059}, {3, 15, 0.191894}};
  const Plane map = flip_map(kWidth, kHeight, pattern(true), pattern(false));
  for (const auto& e : expected)
    CHECK(static_cast<double>(map.at(e.x, e.y)) == doctest::Approx(e.flip).epsilon(2e-4));  // planes are 32-bit floats
  CHECK(masked_mean(map.values, PixelMask(map.values.size(), 1)) == doctest::Approx(0.239354).epsilon(1e-4));
}
