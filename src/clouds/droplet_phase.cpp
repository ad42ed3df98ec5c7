#include "clouds/droplet_phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nepho {

double DropletPhase::operator()(double cosine) const {
  double sum = 0.0;
  for (const Lobe& p : lobes) {
    const double g = p.g, near = std::max((1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine), 1e-12);
    const double hg = (1.0 - g * g) / (4.0 * std::numbers::pi * near * std::sqrt(near));
    sum += p.weight * hg * (1.0 + p.alpha * cosine * cosine) / (1.0 + p.alpha * (1.0 + 2.0 * g * g) / 3.0);
  }
  return sum;
}

double DropletPhase::moment(size_t l) const {
  // Moments of Henyey and Greenstein's lobe are g^l; cos^2 P_l is a sum of three P by the recursion of Legendre's
  // polynomials, used twice.
  const auto n = static_cast<double>(l);
  const double up = (n + 1.0) / (2.0 * n + 1.0), down = n / (2.0 * n + 1.0);
  const double far_up = up * (n + 2.0) / (2.0 * n + 3.0);
  const double same = up * (n + 1.0) / (2.0 * n + 3.0) + (l > 0 ? down * n / (2.0 * n - 1.0) : 0.0);
  const double far_down = l > 1 ? down * (n - 1.0) / (2.0 * n - 1.0) : 0.0;
  double sum = 0.0;
  for (const Lobe& p : lobes) {
    const double power = std::pow(p.g, n);
    const double squares =
        far_up * power * p.g * p.g + same * power + (l > 1 ? far_down * std::pow(p.g, n - 2.0) : 0.0);
    sum += p.weight * (power + p.alpha * squares) / (1.0 + p.alpha * (1.0 + 2.0 * p.g * p.g) / 3.0);
  }
  return sum;
}

shared::PhaseLobes DropletPhase::constants() const {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(lobes[0].g), f(lobes[0].alpha), f(lobes[1].g), f(lobes[1].alpha), f(lobes[1].weight)};
}

DropletPhase droplet_phase(const CloudParams& params) {
  if (params.phase == "mie") return mie_fit(params.droplet_diameter_um);
  const double alpha = params.phase == "cornette_shanks" ? 1.0 : 0.0, back = params.phase_backward_weight;
  return {{{{.g = params.phase_g_forward, .alpha = alpha, .weight = 1.0 - back},
            {.g = params.phase_g_backward, .alpha = 0.0, .weight = back}}}};
}

DropletPhase mie_fit(double diameter_um) {
  const double d = diameter_um;
  const double w = std::exp(-0.599085 / (d - 0.641583) - 0.665888);
  return {{{{.g = std::exp(-0.0990567 / (d - 1.67154)), .alpha = 0.0, .weight = 1.0 - w},
            {.g = std::exp(-2.20679 / (d + 3.91029) - 0.428934),
             .alpha = std::exp(3.62489 - 8.29288 / (d + 5.52825)),
             .weight = w}}}};
}

}  // namespace nepho
