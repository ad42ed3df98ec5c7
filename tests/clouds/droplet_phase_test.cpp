// Phase functions of droplets against closed forms, quadrature and Lorenz-Mie theory.
#include "clouds/droplet_phase.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;

std::vector<CloudParams> phases() {
  std::vector<CloudParams> all(6);
  all[1].phase = "cornette_shanks";
  all[2].phase = "cornette_shanks";
  all[2].phase_g_forward = -0.4;
  all[2].phase_backward_weight = 0.0;
  for (size_t i = 3; i < 6; ++i) all[i].phase = "mie";
  all[3].droplet_diameter_um = 5.0;
  all[4].droplet_diameter_um = 20.0;
  all[5].droplet_diameter_um = 50.0;
  return all;
}

/// Integral over the sphere of a function of angle, by nodes that crowd around forward.
template <typename F>
double sphere(F&& f) {
  constexpr int kNodes = 400000;
  double sum = 0.0;
  for (int i = 0; i < kNodes; ++i) {
    const double u = (i + 0.5) / kNodes, theta = kPi * u * u * u;
    sum += f(theta) * 2.0 * kPi * std::sin(theta) * 3.0 * kPi * u * u / kNodes;
  }
  return sum;
}

}  // namespace

TEST_CASE("phase functions integrate to 1 over the sphere, and their moments are those of quadrature") {
  for (const CloudParams& params : phases()) {
    CAPTURE(params.phase);
    CAPTURE(params.droplet_diameter_um);
    const DropletPhase phase = droplet_phase(params);
    CHECK(phase.moment(0) == doctest::Approx(1.0).epsilon(1e-12));
    for (const unsigned l : {0u, 1u, 2u, 3u, 7u, 40u}) {
      CAPTURE(l);
      const double by_nodes = sphere([&](double theta) {
        const double c = std::cos(theta);
        double before = 0.0, now = 1.0;
        for (unsigned n = 0; n < l; ++n) {
          const double next = ((2.0 * n + 1.0) * c * now - n * before) / (n + 1.0);
          before = now;
          now = next;
        }
        return phase(c) * now;
      });
      CHECK(std::abs(phase.moment(l) - by_nodes) < 1e-7);
    }
  }
}

TEST_CASE("shaders have the same phase function") {
  for (const CloudParams& params : phases()) {
    CAPTURE(params.phase);
    CAPTURE(params.droplet_diameter_um);
    const DropletPhase phase = droplet_phase(params);
    // Below 2 degrees a float's cosine is too coarse to compare by.
    for (double deg = 2.0; deg <= 180.0; deg += 1.7) {
      const double c = std::cos(deg * kPi / 180.0);
      CHECK(static_cast<double>(shared::phase_lobes(phase.constants(), static_cast<float>(c))) ==
            doctest::Approx(phase(static_cast<double>(static_cast<float>(c)))).epsilon(1e-3));
    }
  }
}

TEST_CASE("the lobes are those of the literature") {
  // Cornette and Shanks 1992: 3/2 (1 - g^2) (1 + c^2) / (4 pi (2 + g^2) (1 + g^2 - 2 g c)^(3/2)); of g 0 Rayleigh's.
  for (const double c : {-1.0, -0.3, 0.0, 0.6, 1.0}) {
    const double g = 0.7;
    CHECK(static_cast<double>(shared::phase_draine(static_cast<float>(c), 0.7f, 1.0f)) ==
          doctest::Approx(1.5 * (1.0 - g * g) * (1.0 + c * c) /
                          (4.0 * kPi * (2.0 + g * g) * std::pow(1.0 + g * g - 2.0 * g * c, 1.5)))
              .epsilon(1e-5));
    CHECK(static_cast<double>(shared::phase_draine(static_cast<float>(c), 0.0f, 1.0f)) ==
          doctest::Approx(3.0 / (16.0 * kPi) * (1.0 + c * c)).epsilon(1e-6));
    CHECK(shared::phase_draine(static_cast<float>(c), 0.85f, 0.0f) == shared::phase_hg(static_cast<float>(c), 0.85f));
  }
  // Mean cosine of Cornette and Shanks (their equation 8): 3 g (4 + g^2) / (5 (2 + g^2)).
  CloudParams cornette;
  cornette.phase = "cornette_shanks";
  cornette.phase_backward_weight = 0.0;
  cornette.phase_g_forward = 0.6;
  CHECK(droplet_phase(cornette).moment(1) == doctest::Approx(3.0 * 0.6 * 4.36 / (5.0 * 2.36)).epsilon(1e-12));
  // Draine 2003: g (1 + alpha (3 + 2 g^2) / 5) / (1 + alpha (1 + 2 g^2) / 3).
  const DropletPhase draine{{{{.g = 0.55, .alpha = 22.0, .weight = 1.0}, {}}}};
  CHECK(draine.moment(1) ==
        doctest::Approx(0.55 * (1.0 + 22.0 * 3.605 / 5.0) / (1.0 + 22.0 * 1.605 / 3.0)).epsilon(1e-12));
}

// Lorenz-Mie theory (Bohren and Huffman's BHMIE) of water, n = 1.3337, at 0.55 um, diameters spread by a tenth; means
// over angles, 1/sr, and the mean cosine. The fit leaves out bows (about 140 degrees) and glory (beyond 175), and is
// too dark by a fifth around 75 degrees and too bright by a half around 125.
TEST_CASE("the fit to Mie's phase function is within 16 % of it from 5 to 60 degrees and near 160") {
  struct Window {
    double from_deg, to_deg, mie[3];
  };
  const Window windows[] = {{5.0, 10.0, {1.002, 0.7752, 0.6568}},
                            {10.0, 20.0, {0.4511, 0.4359, 0.4282}},
                            {20.0, 40.0, {0.18, 0.1805, 0.1819}},
                            {40.0, 60.0, {0.04903, 0.04747, 0.04662}},
                            {150.0, 170.0, {0.01201, 0.01046, 0.008595}}};
  const double diameters[3] = {10.0, 20.0, 50.0}, means[3] = {0.8514, 0.8653, 0.8752};
  for (int i = 0; i < 3; ++i) {
    const DropletPhase phase = mie_fit(diameters[i]);
    CAPTURE(diameters[i]);
    CHECK(std::abs(phase.moment(1) - means[i]) < 0.017);
    for (const Window& w : windows) {
      CAPTURE(w.from_deg);
      double sum = 0.0, all = 0.0;
      for (int k = 0; k < 2000; ++k) {
        const double theta = (w.from_deg + (w.to_deg - w.from_deg) * (k + 0.5) / 2000.0) * kPi / 180.0;
        sum += phase(std::cos(theta)) * std::sin(theta);
        all += std::sin(theta);
      }
      CHECK(sum / all == doctest::Approx(w.mie[i]).epsilon(0.16));
    }
  }
  CHECK(mie_fit(5.0).lobes[0].weight + mie_fit(5.0).lobes[1].weight == 1.0);
}
