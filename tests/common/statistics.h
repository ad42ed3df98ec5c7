#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace nepho::test {

/// Distance of a histogram from what was expected, in standard deviations of chi-square (k - 1 degrees of freedom,
/// variance 2 (k - 1)). Bins that expect fewer than 20 are joined with their neighbours.
inline double chi_square_sigmas(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi2 = 0.0, count = 0.0, expect = 0.0;
  size_t bins = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    count += counts[i];
    expect += expected[i];
    if (expect < 20.0) continue;
    chi2 += (count - expect) * (count - expect) / expect;
    ++bins;
    count = expect = 0.0;
  }
  const double freedom = static_cast<double>(bins) - 1.0;
  return (chi2 - freedom) / std::sqrt(2.0 * freedom);
}

/// Values of a bounded or thin-tailed distribution as they come.
struct Moments {
  double n = 0.0, sum = 0.0, squares = 0.0;
  void add(double v) {
    n += 1.0;
    sum += v;
    squares += v * v;
  }
  double mean() const { return sum / n; }
  double variance() const { return squares / n - mean() * mean(); }
  /// Standard error of the mean.
  double error() const { return std::sqrt(variance() / n); }
};

}  // namespace nepho::test
