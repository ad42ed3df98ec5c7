#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "clouds/clouds_shared.h"

namespace nepho {
namespace {

TEST_CASE("share_above follows the normal distribution within 0.018 and ends in 0 and 1") {
  for (float z = -4.0f; z <= 4.0f; z += 0.1f)
    CHECK(std::abs(shared::share_above(z * 0.3f, 0.3f) - 0.5 * std::erfc(-z / std::sqrt(2.0))) < 0.018);
  CHECK(shared::share_above(-2.61f, 1.0f) == 0.0f);
  CHECK(shared::share_above(2.61f, 1.0f) == 1.0f);
}

TEST_CASE("clumped_extinction is share x extinction of thin clumps and -log(1 - share) per opaque clump") {
  CHECK(std::abs(shared::clumped_extinction(0.3f, 0.04f, 0.1f) / (0.3f * 0.04f) - 1.0f) < 0.01f);
  CHECK(std::abs(shared::clumped_extinction(0.3f, 0.1f, 500.0f) * 500.0f + std::log(0.7f)) < 1e-3f);
  CHECK(std::abs(shared::clumped_extinction(1.0f, 0.01f, 100.0f) - 0.01f) < 1e-4f);  // nothing to clump
}

TEST_CASE("variance_left falls from 1 to 0") {
  CHECK(shared::variance_left(0.0f, 1.0f, 0.2f) == 1.0f);
  CHECK(shared::variance_left(3.5f, 1.0f, 0.2f) == doctest::Approx(0.5));
  CHECK(shared::variance_left(6.0f, 1.0f, 0.2f) == 0.0f);
}

TEST_CASE(
    "a cell is widest where eta = 0.5^(1 / bias), has a flat base and no end at the top; relief scales its outline") {
  for (const float bias : {0.35f, 0.5f, 1.0f}) {
    const float waist = std::pow(0.5f, 1.0f / bias);
    CHECK(std::abs(shared::excess_needed(waist, bias, 1.15f, 0.0f)) < 1e-3f);
    float last = 0.0f;
    for (float eta = waist; eta < 1.0f; eta += 0.01f) {
      const float need = shared::excess_needed(eta, bias, 1.15f, 0.0f);
      CHECK(need >= last - 1e-4f);
      CHECK(shared::excess_needed(eta, bias, 2.3f, 0.0f) == doctest::Approx(2.0 * need).epsilon(1e-4));
      last = need;
    }
    CHECK(shared::excess_needed(1.0f, bias, 1.15f, 0.0f) > 5.0f);
  }
  // Below the base only what exceeds by 40 deviations per layer thickness.
  CHECK(shared::excess_needed(-0.1f, 1.0f, 0.0f, 0.0f) > 4.0f);
}

TEST_CASE("an anvil spreads beyond the tower below it, and ends at the layer's top") {
  const float tower = shared::excess_needed(0.68f, 0.35f, 0.9f, 1.0f),
              anvil = shared::excess_needed(0.85f, 0.35f, 0.9f, 1.0f);
  CHECK(anvil < tower);
  CHECK(shared::excess_needed(0.85f, 0.35f, 0.9f, 0.0f) > tower);
  CHECK(shared::excess_needed(1.0f, 0.35f, 0.9f, 1.0f) > 2.0f);
}

TEST_CASE("cell_threshold covers the share of a normal field that is asked at the waist") {
  for (const float probit : {-1.5f, -0.3f, 0.4f, 1.2f, 3.0f})
    CHECK(shared::cell_threshold(0.0f, probit) == doctest::Approx(-probit));
  // More coverage never needs more, and more need never less.
  for (float need = 0.0f; need < 3.0f; need += 0.1f)
    for (float probit = -2.0f; probit < 3.0f; probit += 0.25f) {
      CHECK(shared::cell_threshold(need, probit + 0.25f) <= shared::cell_threshold(need, probit));
      CHECK(shared::cell_threshold(need + 0.1f, probit) >= shared::cell_threshold(need, probit));
    }
}

TEST_CASE("the dual-lobe phase function integrates to 1 and has the mean cosine of its lobes") {
  const double g0 = 0.85, g1 = -0.2, w = 0.1;
  double sum = 0.0, cosine = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double c = -1.0 + (i + 0.5) * 2.0 / kSteps;
    const double p = shared::phase_lobes(
        {static_cast<float>(g0), 0.0f, static_cast<float>(g1), 0.0f, static_cast<float>(w)}, static_cast<float>(c));
    sum += p * 2.0 * M_PI * 2.0 / kSteps;
    cosine += p * c * 2.0 * M_PI * 2.0 / kSteps;
  }
  CHECK(std::abs(sum - 1.0) < 1e-3);
  CHECK(std::abs(cosine - ((1 - w) * g0 + w * g1)) < 1e-3);
}

}  // namespace
}  // namespace nepho
