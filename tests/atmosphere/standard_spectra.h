#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace nepho {

/// Bruneton 2017, demo.cc, 360 to 830 nm; written again here so that a slip in the source cannot confirm itself through
/// the tests: these are 1e-27 m^2.
inline double ozone_per_m(double nm) {
  constexpr double section[48] = {1.18,  .2182, .2818, .6636, 1.527, 2.763, 5.52,  8.451, 15.82, 23.16, 36.69, 49.24,
                                  77.52, 90.16, 148,   160.2, 213.9, 275.5, 309.1, 350,   426.6, 467.2, 439.8, 470.1,
                                  501.9, 430.5, 374,   321.5, 266.2, 223.8, 185.2, 147.3, 120.9, 94.23, 74.55, 65.66,
                                  51.05, 41.5,  42.28, 32.37, 24.51, 28.01, 25.34, 16.24, 14.65, 20.78, 13.83, 7.105};
  const double x = std::clamp((nm - 360.0) / 10.0, 0.0, 46.999999);
  const auto i = static_cast<size_t>(x);
  const double f = x - static_cast<double>(i);
  return 5.374e-9 * (section[i] * (1.0 - f) + section[i + 1] * f);
}
/// Scattering by gas at the ground, 1/m (Bruneton 2017).
inline double gas_per_m(double nm) { return 1.24062e-6 * std::pow(nm / 1000.0, -4.0); }

}  // namespace nepho
