#include "atmosphere/luminance.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>

#include "atmosphere/oracle_table.h"

using namespace nepho;

namespace {
double luminance(const glm::dvec3& rgb) { return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722)); }
}  // namespace

TEST_CASE("luminance factors agree with Bruneton's published ones to 2e-5") {
  const glm::dvec3 sky(114974.916437, 71305.954816, 65310.548555), sun(98242.786222, 69954.398112, 66475.012354);
  for (int c = 0; c < 3; ++c) {
    CHECK(sky_luminance_factors()[c] == doctest::Approx(sky[c]).epsilon(2e-5));
    CHECK(sun_luminance_factors()[c] == doctest::Approx(sun[c]).epsilon(2e-5));
  }
}

TEST_CASE("the sun above the air gives about 133,000 lux of nearly white light") {
  const glm::dvec3 sun(sun_illuminance_at_1au({}));
  CHECK(luminance(sun) > 130000.0);  // ASTM G173: 1 solar constant of 98 lm/W
  CHECK(luminance(sun) < 135000.0);
  CHECK(sun.r / sun.b == doctest::Approx(1.14).epsilon(0.05));
}

TEST_CASE("a horizontal surface at noon gets about 100,000 lux, by the exact irradiances of the oracle") {
  const OracleTable table("ground_irradiance.csv");
  int seen = 0;
  for (size_t i = 0; i < table.size(); ++i) {
    const double mu_s = table.number(i, "mu_s");
    if (table.number(i, "r_m") != 6360000.0 || mu_s < 0.75 || mu_s > 0.95) continue;
    const double lux = luminance(sun_luminance_factors() * table.rgb(i, "direct_exact") +
                                 sky_luminance_factors() * table.rgb(i, "indirect_integrated"));
    CHECK(lux > 85000.0);
    CHECK(lux < 120000.0);
    ++seen;
  }
  CHECK(seen > 0);
}
