// The phase function cut for transport, and light that went nearly straight on.
#include "clouds/beam_table.h"

#include <cmath>
#include <numbers>

#include "clouds/light_shared.h"
#include "doctest/doctest.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;

/// Integral over the sphere of an order of the table, times cos^power of the angle.
double integral(const std::vector<float>& table, size_t texels, size_t order, int power) {
  double sum = 0.0;
  const auto value = [&](size_t i) { return static_cast<double>(table[((order / 4) * texels + i) * 4 + order % 4]); };
  constexpr size_t kNodes = 200000;
  for (size_t n = 0; n < kNodes; ++n) {
    const double u = (static_cast<double>(n) + 0.5) / kNodes, theta = kPi * u * u;
    const double at = u * static_cast<double>(texels - 1);
    const size_t i = std::min(static_cast<size_t>(at), texels - 2);
    const double f = at - static_cast<double>(i);
    const double width = 2.0 * kPi * u / kNodes;
    sum += ((1.0 - f) * value(i) + f * value(i + 1)) * std::pow(std::cos(theta), power) * 2.0 * kPi * std::sin(theta) *
           width;
  }
  return sum;
}

}  // namespace

TEST_CASE("a cut keeps the mean cosine; of an even function nothing goes straight on") {
  const PhaseCut cut = cut_phase(0.745, 0.552);
  CHECK(cut.forward_share + (1.0 - cut.forward_share) * cut.wide_g == doctest::Approx(0.745));
  CHECK(cut_phase(0.0, 0.0).forward_share == 0.0);
  CHECK(cut_phase(0.0, 0.0).wide_g == 0.0);
}

TEST_CASE(
    "the beam's first order is the phase function; every order holds all light and turns it as much in the mean") {
  CloudParams dual, cornette, fog, cloud;
  cornette.phase = "cornette_shanks";
  fog.phase = cloud.phase = "mie";
  fog.droplet_diameter_um = 5.0;
  cloud.droplet_diameter_um = 50.0;
  for (const CloudParams& params : {dual, cornette, fog, cloud}) {
    CAPTURE(params.phase);
    CAPTURE(params.droplet_diameter_um);
    const DropletPhase phase = droplet_phase(params);
    const PhaseCut cut = cut_phase(phase.moment(1), phase.moment(4));
    const size_t texels = shared::kBeamTexels;
    const std::vector<float> table = beam_table(phase, cut, texels, shared::kBeamOrders);
    REQUIRE(table.size() == texels * shared::kBeamOrders);
    for (size_t i = 0; i < texels; i += 37) {
      const double u = static_cast<double>(i) / static_cast<double>(texels - 1);
      CHECK(static_cast<double>(table[4 * i]) == doctest::Approx(phase(std::cos(kPi * u * u))).epsilon(1e-6));
    }
    for (size_t k = 0; k < shared::kBeamOrders; ++k) {
      CAPTURE(k);
      CHECK(integral(table, texels, k, 0) == doctest::Approx(1.0).epsilon(2e-3));
      // Going straight on turns nothing: the last scattering alone does.
      CHECK(integral(table, texels, k, 1) == doctest::Approx(phase.moment(1)).epsilon(3e-3));
    }
    // Each order is wider than the one before.
    for (size_t k = 1; k < shared::kBeamOrders; ++k)
      CHECK(table[((k / 4) * texels) * 4 + k % 4] < table[(((k - 1) / 4) * texels) * 4 + (k - 1) % 4]);
  }
}

TEST_CASE("light scattered more than once is weighed in the beam, light scattered once is not") {
  const DropletPhase phase = droplet_phase({});
  const PhaseCut cut = cut_phase(phase.moment(1), phase.moment(4));
  const std::vector<float> one = beam_table(phase, cut, 16, 8), half = beam_table(phase, cut, 16, 8, 0.5);
  for (size_t i = 0; i < 16; ++i)
    for (size_t k = 0; k < 8; ++k) {
      const size_t at = ((k / 4) * 16 + i) * 4 + k % 4;
      CHECK(half[at] == doctest::Approx(k == 0 ? one[at] : 0.5f * one[at]));
    }
}
