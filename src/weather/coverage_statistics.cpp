#include "weather/coverage_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nepho {

namespace {
double normal_share(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
}  // namespace

double exact_probit(double p) {
  if (p <= 1e-12) return -8.0;
  if (p >= 1.0 - 1e-12) return 8.0;
  constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                          1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02, 6.680131188771972e+01,
                          -1.328068155288572e+01};
  constexpr double c[] = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                          -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr double d[] = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00, 3.754408661907416e+00};
  if (p < 0.02425 || p > 1.0 - 0.02425) {
    const double q = std::sqrt(-2.0 * std::log(std::min(p, 1.0 - p)));
    const double x = (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
                     ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1.0);
    return p < 0.5 ? x : -x;
  }
  const double q = p - 0.5, r = q * q;
  return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
         (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1.0);
}

double local_coverage(double rank, double mean_coverage, double contrast) {
  if (mean_coverage <= 0.0) return 0.0;
  if (mean_coverage >= 1.0) return 1.0;
  const double s = std::clamp(contrast, 0.0, 0.95);
  return normal_share((exact_probit(mean_coverage) + s * exact_probit(rank)) / std::sqrt(1.0 - s * s));
}

std::vector<uint16_t> area_ranks(std::span<const float> values, uint32_t channels, uint32_t channel,
                                 std::span<const float> weights) {
  const size_t count = weights.size();
  float low = values[channel], high = low;
  for (size_t i = 0; i < count; ++i) {
    low = std::min(low, values[i * channels + channel]);
    high = std::max(high, values[i * channels + channel]);
  }
  // A histogram with linear steps inside its bins: as good as sorting, in linear time.
  constexpr size_t kBins = 65536;
  const double lowest = static_cast<double>(low), range = std::max(1e-9, static_cast<double>(high) - lowest);
  const auto bin_of = [&](float v) { return (static_cast<double>(v) - lowest) / range * (kBins - 1e-6); };
  std::vector<double> below(kBins + 1, 0.0);
  for (size_t i = 0; i < count; ++i)
    below[static_cast<size_t>(bin_of(values[i * channels + channel])) + 1] += static_cast<double>(weights[i]);
  for (size_t i = 0; i < kBins; ++i) below[i + 1] += below[i];
  std::vector<uint16_t> ranks(count);
  for (size_t i = 0; i < count; ++i) {
    const double at = bin_of(values[i * channels + channel]);
    const auto bin = static_cast<size_t>(at);
    const double share = (below[bin] + (at - static_cast<double>(bin)) * (below[bin + 1] - below[bin])) / below[kBins];
    ranks[i] = static_cast<uint16_t>(std::clamp(share, 0.0, 1.0) * 65535.0 + 0.5);
  }
  return ranks;
}

}  // namespace nepho
