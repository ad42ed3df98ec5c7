#include "astro/moonlight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "astro/spectral_color.h"

namespace nepho {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSunMagnitude = -26.74, kFullMoonMagnitude = -12.73;  // V
constexpr double kMeanMoonDistance_m = 384400e3;
constexpr double kAllenEnds_rad = 150.0 * kPi / 180.0;
constexpr double kEarthGeometricAlbedo = 0.367, kEarthRadius_m = 6371e3;
constexpr double kSun_K = 5778.0;
constexpr double kMoonMinusSun_BV = 0.92 - 0.65, kEarthshineMinusMoonlight_BV = -0.17;

/// Magnitudes below full moon.
double allen_dimming(double phase_angle_rad) {
  const double a = std::abs(deg_from_rad(phase_angle_rad));
  return 0.026 * a + 4.0e-9 * a * a * a * a;
}

/// Lommel-Seeliger sphere: brightness over that at full phase.
double lommel_seeliger_phase(double a) {
  const double x = std::max(0.5 * (kPi - a), 0.0);  // from the complement: no difference of large tangents at new moon
  if (x < 1e-3) return 2.0 / 3.0 * x * x;
  return 1.0 - std::cos(x) / std::tan(x) * std::log(1.0 / std::tan(0.25 * a));
}

/// Power of wavelength of an albedo that adds `bv` to B-V, taken between 440 and 550 nm.
double power_from_bv(double bv) { return 0.4 * std::log(10.0) * bv / std::log(550.0 / 440.0); }

dvec3 reflected_color(double bv) { return rec709_from_planck(kSun_K, power_from_bv(bv)) / rec709_from_planck(kSun_K); }

}  // namespace

double moon_sun_illuminance_ratio(double phase_angle_rad, double moon_distance_m, double sun_moon_distance_au) {
  const double a = std::clamp(std::abs(phase_angle_rad), 0.0, kPi);
  const double measured = std::min(a, kAllenEnds_rad);
  const double magnitude = kFullMoonMagnitude + allen_dimming(measured) - kSunMagnitude;
  const double nearer = kMeanMoonDistance_m / moon_distance_m;
  double ratio = std::pow(10.0, -0.4 * magnitude) * nearer * nearer / (sun_moon_distance_au * sun_moon_distance_au);
  if (a > measured) ratio *= lommel_seeliger_phase(a) / lommel_seeliger_phase(measured);
  return ratio;
}

double lambert_phase(double a) { return (std::sin(a) + (kPi - a) * std::cos(a)) / kPi; }

double earthshine_illuminance_ratio(double moon_phase_angle_rad, double earth_moon_distance_m,
                                    double sun_earth_distance_au) {
  const double size = kEarthRadius_m / earth_moon_distance_m;
  return kEarthGeometricAlbedo * lambert_phase(kPi - moon_phase_angle_rad) * size * size /
         (sun_earth_distance_au * sun_earth_distance_au);
}

dvec3 moonlight_color() { return reflected_color(kMoonMinusSun_BV); }
dvec3 earthshine_color() { return reflected_color(kMoonMinusSun_BV + kEarthshineMinusMoonlight_BV); }

}  // namespace nepho
