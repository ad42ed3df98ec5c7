#include "clouds/beam_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nepho {
namespace {

constexpr double kPi = std::numbers::pi;
/// Moments are summed until those of the narrowest lobe are below kLeastMoment: 160 at g 0.85, 6400 at 0.998.
constexpr double kLeastMoment = 5e-12, kMostMoments = 8192.0;

}  // namespace

PhaseCut cut_phase(double p1, double p2) {
  const double f = std::clamp(p2, 0.0, 0.98);
  return {.forward_share = f, .wide_g = std::clamp((p1 - f) / (1.0 - f), -0.95, 0.95)};
}

std::vector<float> beam_table(const DropletPhase& phase, const PhaseCut& cut, size_t texels, size_t orders,
                              double more) {
  double narrowest = 0.1;
  for (const DropletPhase::Lobe& lobe : phase.lobes)
    if (lobe.weight > 0.0) narrowest = std::max(narrowest, std::abs(lobe.g));
  // Orders but the first hold products of two moments at least.
  const double wanted = std::log(kLeastMoment) / std::log(narrowest);
  const auto count = static_cast<size_t>(std::ceil(std::min(std::max(160.0, 0.5 * wanted), kMostMoments)));
  const double f = cut.forward_share;
  // What is cut off rings, unless it fades out before: lobes narrower than 0.03 degrees become as wide.
  const double fade = 0.5 * wanted > kMostMoments ? 18.0 / (kMostMoments * kMostMoments) : 0.0;
  std::vector<double> p(count), q(count);
  for (size_t l = 0; l < count && f > 0.0; ++l) {
    const auto n = static_cast<double>(l);
    p[l] = (2.0 * n + 1.0) / (4.0 * kPi) * phase.moment(l) * std::exp(-fade * n * n);
    // One scattering of the forward part multiplies moment l by q.
    q[l] = std::clamp((phase.moment(l) - (1.0 - f) * std::pow(cut.wide_g, n)) / f, -1.0, 1.0);
  }
  std::vector<float> out(texels * orders, 0.0f);
  for (size_t i = 0; i < texels; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(texels - 1);
    const double c = std::cos(kPi * u * u);
    std::vector<double> sums(orders, 0.0);
    double before = 0.0, now = 1.0;
    for (size_t l = 0; l < count && f > 0.0; ++l) {
      const auto n = static_cast<double>(l);
      double term = p[l] * now;
      for (size_t k = 1; k < orders; ++k) sums[k] += term *= q[l];
      const double next = ((2.0 * n + 1.0) * c * now - n * before) / (n + 1.0);
      before = now;
      now = next;
    }
    for (size_t k = 1; k < orders; ++k) sums[k] *= more;
    sums[0] = phase(c);
    for (size_t k = 0; k < orders; ++k) out[((k / 4) * texels + i) * 4 + k % 4] = static_cast<float>(sums[k]);
  }
  return out;
}

}  // namespace nepho
