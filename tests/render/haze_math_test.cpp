#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "render/haze_shared.h"

using namespace nepho::shared;

namespace {

constexpr double kR = 6378137.0;

/// Height above the sphere in double, without cancellation.
double height_at(double h, double mu, double t) {
  const double rho2 = h * (2.0 * kR + h) + t * (2.0 * (kR + h) * mu + t);
  return rho2 / (kR + std::sqrt(kR * kR + rho2));
}

double density_at(const HazeLayerData& layer, double h) {
  if (h < static_cast<double>(layer.bottom_m) || h >= static_cast<double>(layer.top_m)) return 0.0;
  return std::exp(-std::max(h - static_cast<double>(layer.base_m), 0.0) / static_cast<double>(layer.scale_height_m));
}

/// The column by brute force, with the path cut where it meets the layer's faces and its lowest point.
double column_by_quadrature(const HazeLayerData& layer, double h, double mu, double length) {
  std::vector<double> cuts = {0.0, length};
  const double low = -(kR + h) * mu;
  if (low > 0.0 && low < length) cuts.push_back(low);
  for (const float face : {layer.bottom_m, layer.base_m, layer.top_m}) {
    const double r_mu = (kR + h) * mu, to = static_cast<double>(face);
    const double inside = r_mu * r_mu + (to - h) * (2.0 * kR + to + h);
    if (inside < 0.0) continue;
    for (const double t : {-r_mu - std::sqrt(inside), -r_mu + std::sqrt(inside)})
      if (t > 0.0 && t < length) cuts.push_back(t);
  }
  std::sort(cuts.begin(), cuts.end());
  double sum = 0.0;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    // Midpoints, dense at both ends: t = a + L (3 s^2 - 2 s^3).
    const double a = cuts[i], l = cuts[i + 1] - cuts[i];
    constexpr int kSteps = 20000;
    for (int k = 0; k < kSteps; ++k) {
      const double s = (k + 0.5) / kSteps;
      sum += density_at(layer, height_at(h, mu, a + l * s * s * (3.0 - 2.0 * s))) * l * 6.0 * s * (1.0 - s) / kSteps;
    }
  }
  return sum;
}

HazeLayerData layer_of(float bottom, float base, float top, float scale) {
  return {.extinction_per_m = 1e-3f,
          .bottom_m = bottom,
          .base_m = base,
          .top_m = top,
          .scale_height_m = scale,
          .albedo = 1.0f,
          .g = 0.0f,
          .pad0 = 0.0f};
}

}  // namespace

TEST_CASE("erfc_scaled is exp(x^2) erfc(x), to 1e-6") {
  for (const double x : {0.0, 0.01, 0.3, 1.0, 2.5, 5.0})
    CHECK(static_cast<double>(erfc_scaled(static_cast<float>(x))) ==
          doctest::Approx(std::exp(x * x) * std::erfc(x)).epsilon(1e-6));
  // 1 / (x sqrt(pi)) far out.
  CHECK(static_cast<double>(erfc_scaled(1e6f)) == doctest::Approx(1.0 / (1e6 * std::sqrt(M_PI))).epsilon(1e-6));
}

TEST_CASE("haze column of a level ray at sea level is sqrt(pi R H / 2) one way to space (Chapman at 90 degrees)") {
  const HazeLayerData layer = layer_of(-1e4f, 0.0f, 14e3f, 1000.0f);
  const double chapman = std::sqrt(0.5 * M_PI * kR * 1000.0);
  CHECK(static_cast<double>(haze_column(layer, 6378137.0f, 0.0f, 0.0f, 2e6f)) ==
        doctest::Approx(chapman).epsilon(1e-3));
  // Straight up: a scale height; a layer without a bottom is even below its base.
  CHECK(static_cast<double>(haze_column(layer, 6378137.0f, 0.0f, 1.0f, 1e5f)) == doctest::Approx(1000.0).epsilon(1e-4));
  CHECK(static_cast<double>(haze_column(layer, 6378137.0f, -100.0f, 1.0f, 1e5f)) ==
        doctest::Approx(1100.0).epsilon(1e-4));
}

TEST_CASE(
    "haze column agrees with quadrature within 0.3 %, from the ground to orbit, up, down, level and through the limb") {
  const HazeLayerData layers[] = {
      layer_of(-1e4f, 0.0f, 14.0f * 1200.0f, 1200.0f),  // haze
      layer_of(-1e4f, 150.0f, 150.0f + 420.0f, 30.0f),  // fog with a soft top
      layer_of(-1e4f, 80.0f, 80.0f, 10.0f),             // fog with a hard top
      layer_of(2000.0f, 2500.0f, 4000.0f, 900.0f),      // dust aloft
      layer_of(1000.0f, 0.0f, 9000.0f, 2000.0f),        // its bottom above its base
  };
  double worst = 0.0;
  for (const HazeLayerData& layer : layers)
    for (const double h : {2.0, 100.0, 1500.0, 3000.0, 10e3, 95e3})
      for (const double mu : {1.0, 0.7, 0.2, 0.05, 0.01, 0.0, -0.002, -0.01, -0.03, -0.1, -0.175, -0.5, -1.0})
        for (const double length : {30.0, 1e3, 2e4, 1.5e5, 2e6}) {
          const double r_mu = (kR + h) * mu, ground = r_mu * r_mu - h * (2.0 * kR + h);
          double l = length;
          if (mu < 0.0 && ground >= 0.0) l = std::min(l, h * (2.0 * kR + h) / (std::sqrt(ground) - r_mu));
          const double truth = column_by_quadrature(layer, h, mu, l);
          const double got = static_cast<double>(
              haze_column(layer, 6378137.0f, static_cast<float>(h), static_cast<float>(mu), static_cast<float>(l)));
          // Heights are good to 5 cm at grazing distances: so much of a scale height, of the column.
          const double allowed = 0.003 * truth + 1e-3 * static_cast<double>(layer.scale_height_m);
          worst = std::max(worst, std::abs(got - truth) / (truth + static_cast<double>(layer.scale_height_m)));
          CHECK_MESSAGE(std::abs(got - truth) <= allowed, "base ", layer.base_m, " h ", h, " mu ", mu, " length ", l,
                        ": ", got, " of ", truth);
        }
  MESSAGE("worst " << worst);
}

TEST_CASE("haze columns add up along a ray") {
  const HazeLayerData layer = layer_of(-1e4f, 50.0f, 5000.0f, 300.0f);
  for (const float mu : {0.3f, 0.0f, -0.02f}) {
    const float r = 6378137.0f, h = 800.0f, l = 20e3f, part = 7e3f;
    const float h1 = haze_height_along(r, h, mu, part), mu1 = ((r + h) * mu + part) / (r + h1);
    const float whole = haze_column(layer, r, h, mu, l);
    CHECK(haze_column(layer, r, h, mu, part) + haze_column(layer, r, h1, mu1, l - part) ==
          doctest::Approx(whole).epsilon(1e-3));
  }
}

TEST_CASE("haze column above a height is that of a vertical ray") {
  for (const HazeLayerData& layer :
       {layer_of(-1e4f, 150.0f, 570.0f, 30.0f), layer_of(2000.0f, 2500.0f, 4000.0f, 900.0f),
        layer_of(1000.0f, 0.0f, 9000.0f, 2000.0f)})
    for (const float h : {0.0f, 200.0f, 2200.0f, 3000.0f})
      CHECK(haze_column_above(layer, h) ==
            doctest::Approx(haze_column(layer, 6378137.0f, h, 1.0f, 1e5f)).epsilon(1e-3));
}

namespace {
/// Share of a beam's photons that leaves an even, isotropic, conservative slab below: direct and scattered.
double transmitted_by_photons(double tau, double mu0, int photons) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int through = 0;
  for (int i = 0; i < photons; ++i) {
    double depth = 0.0, mu = mu0;  // mu > 0: down
    for (;;) {
      depth -= mu * std::log(1.0 - uniform(random));
      if (depth < 0.0) break;
      if (depth > tau) {
        ++through;
        break;
      }
      mu = 2.0 * uniform(random) - 1.0;
    }
  }
  return static_cast<double>(through) / photons;
}
}  // namespace

TEST_CASE("haze two streams transmit through isotropic slabs what photons do, within 3 % of the incident light") {
  for (const float tau : {0.2f, 1.0f, 4.0f, 16.0f})
    for (const float mu0 : {1.0f, 0.5f, 0.2f}) {
      const HazeDiffuse d = haze_diffuse_beam(tau, tau, mu0);
      const double transmitted = static_cast<double>(d.ground / mu0 + std::exp(-tau / mu0));
      const double truth =
          transmitted_by_photons(static_cast<double>(tau), static_cast<double>(mu0), 40000);  // +- 0.25 %
      CHECK_MESSAGE(std::abs(transmitted - truth) < 0.03, "depth ", tau, ", cosine ", mu0, ": ", transmitted, " of ",
                    truth);
    }
}

TEST_CASE(
    "haze two streams: a thin slab scatters nothing, a thick one sends all back: fluence 2 (1 + 2 mu0 ...) at its "
    "top") {
  CHECK(haze_diffuse_beam(0.0f, 1e-6f, 0.4f).fluence < 1e-4f);
  // Semi-infinite: the flux upwards at the top is all that came, mu0; its fluence is 2 mu0.
  CHECK(haze_diffuse_beam(0.0f, 1e5f, 0.4f).fluence == doctest::Approx(2.0 * 0.4).epsilon(2e-2));
  CHECK(haze_sky_fluence(0.0f, 0.0f) == doctest::Approx(2.0));
  CHECK(haze_survival(1.0f, 7.0f) == doctest::Approx(1.0));
  CHECK(haze_survival(0.0f, 7.0f) == doctest::Approx(0.0));
}
