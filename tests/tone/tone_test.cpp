#include "tone/tone.h"

#include <doctest/doctest.h>

#include <cmath>

#include "base/error.h"
#include "common/tonemap.h"

using namespace nepho;

namespace {

/// EV100 of an evenly lit picture: all of it is its brightest part, at 0.9 of saturation; darker by night, closed form.
double expected_ev100(double luminance) {
  const double metered = std::log2(luminance / (1.2 * 0.9));
  const double middle_grey = 0.18 * 1.2 * std::exp2(metered);
  return metered + 4.5 / (1.0 + std::pow(middle_grey / 0.01, 0.7));
}

}  // namespace

TEST_CASE("the CPU's meter puts an evenly lit picture at 0.9 of saturation, darker by night") {
  for (const float l : {3.0e4f, 300.0f, 1.0f, 0.02f}) {
    const std::vector<glm::vec3> rgb(64 * 36, glm::vec3(l));
    // A percentile lies anywhere in its bin of 55/256 stops.
    CHECK(std::abs(metered_ev100(64, 36, rgb) - expected_ev100(static_cast<double>(l))) < 55.0 / 256.0 + 0.01);
  }
}

TEST_CASE("the CPU's meter ignores black and the sun's disc, and keeps limits and compensation") {
  std::vector<glm::vec3> rgb(100 * 100, glm::vec3(2000.0f));
  const double alone = metered_ev100(100, 100, rgb);
  for (size_t i = 0; i < 3000; ++i) rgb[i] = glm::vec3(i < 2000 ? 0.0f : 1.0e9f);
  CHECK(metered_ev100(100, 100, rgb) == doctest::Approx(alone).epsilon(1e-5));
  CHECK(metered_ev100(100, 100, rgb, {.compensation_ev = 1.5}) == doctest::Approx(alone - 1.5).epsilon(1e-5));
  CHECK(metered_ev100(100, 100, rgb, {.min_ev100 = 15.0}) == 15.0);
  CHECK(metered_ev100(100, 100, rgb, {.max_ev100 = 3.0}) == 3.0);
  CHECK(metered_ev100(1, 1, std::vector{glm::vec3(0.0f)}, {.min_ev100 = 2.0}) == 2.0);  // nothing to meter
}

TEST_CASE("display values: middle grey of the curve linear is the sRGB code of 0.18, and white clips at 1") {
  const double ev100 = 10.0;
  const float saturation = static_cast<float>(1.2 * std::exp2(ev100));  // cd/m2
  const auto shown = display_from_linear(std::vector{glm::vec3(0.18f * saturation), glm::vec3(5.0f * saturation)},
                                         {.ev100 = ev100, .curve = tone_curve_id("linear")});
  CHECK(shown[0].g == doctest::Approx(1.055 * std::pow(0.18, 1.0 / 2.4) - 0.055).epsilon(1e-5));
  CHECK(shown[1].r == doctest::Approx(1.0).epsilon(1e-6));
  CHECK(tone_curve_id("agx") == shared::kToneAgx);
  CHECK_THROWS_AS(tone_curve_id("filmic"), Error);
}
