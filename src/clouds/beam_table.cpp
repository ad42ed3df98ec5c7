#include "clouds/beam_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/phase.h"

namespace nepho {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr size_t kMoments = 160;  ///< 0.85^160 is 5e-12

double phase_hg(double cosine, double g) {
  const double d = std::max(1.0 + g * g - 2.0 * g * cosine, 1e-12);
  return (1.0 - g * g) / (4.0 * kPi * d * std::sqrt(d));
}

}  // namespace

PhaseCut cut_phase(double p1, double p2) {
  const double f = std::clamp(p2, 0.0, 0.98);
  return {.forward_share = f, .wide_g = std::clamp((p1 - f) / (1.0 - f), -0.95, 0.95)};
}

std::vector<double> phase_moments(const std::function<double(double)>& phase, size_t count) {
  // theta = pi u^3: nodes crowd where the function peaks. Midpoints.
  constexpr size_t kNodes = 20000;
  std::vector<double> moments(count, 0.0);
  double all = 0.0;
  for (size_t i = 0; i < kNodes; ++i) {
    const double u = (static_cast<double>(i) + 0.5) / kNodes;
    const double theta = kPi * u * u * u, c = std::cos(theta);
    const double w = phase(c) * 2.0 * kPi * std::sin(theta) * 3.0 * kPi * u * u / kNodes;
    all += w;
    double before = 0.0, now = 1.0;
    for (size_t l = 0; l < count; ++l) {
      moments[l] += w * now;
      const double n = static_cast<double>(l);
      const double next = ((2.0 * n + 1.0) * c * now - n * before) / (n + 1.0);
      before = now;
      now = next;
    }
  }
  for (double& m : moments) m /= all;
  return moments;
}

std::vector<float> beam_table(const std::function<double(double)>& phase, const PhaseCut& cut, size_t texels,
                              size_t orders) {
  const std::vector<double> p = phase_moments(phase, kMoments);
  const double f = cut.forward_share;
  std::vector<float> out(texels * orders, 0.0f);
  for (size_t i = 0; i < texels; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(texels - 1);
    const double c = std::cos(kPi * u * u);
    std::vector<double> sums(orders, 0.0);
    double before = 0.0, now = 1.0;
    for (size_t l = 0; l < kMoments && f > 0.0; ++l) {
      const double n = static_cast<double>(l);
      // One scattering of the forward part multiplies moment l by q.
      const double q = std::clamp((p[l] - (1.0 - f) * std::pow(cut.wide_g, n)) / f, -1.0, 1.0);
      double term = (2.0 * n + 1.0) / (4.0 * kPi) * p[l] * now;
      for (size_t k = 1; k < orders; ++k) sums[k] += term *= q;
      const double next = ((2.0 * n + 1.0) * c * now - n * before) / (n + 1.0);
      before = now;
      now = next;
    }
    sums[0] = phase(c);
    for (size_t k = 0; k < orders; ++k) out[((k / 4) * texels + i) * 4 + k % 4] = static_cast<float>(sums[k]);
  }
  return out;
}

std::function<double(double)> cloud_phase(const CloudParams& params) {
  const double g0 = params.phase_g_forward, g1 = params.phase_g_backward, w = params.phase_backward_weight;
  return [=](double c) { return (1.0 - w) * phase_hg(c, g0) + w * phase_hg(c, g1); };
}

}  // namespace nepho
