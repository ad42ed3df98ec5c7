#include "astro/spectral_color.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace nepho {

namespace {

/// A Gaussian with one width below its centre and another above.
double lobe(double wavelength_nm, double centre, double below, double above) {
  const double t = (wavelength_nm - centre) / (wavelength_nm < centre ? below : above);
  return std::exp(-0.5 * t * t);
}

dvec3 xyz_of(double l) {
  return dvec3(
      1.056 * lobe(l, 599.8, 37.9, 31.0) + 0.362 * lobe(l, 442.0, 16.0, 26.7) - 0.065 * lobe(l, 501.1, 20.4, 26.2),
      0.821 * lobe(l, 568.8, 46.9, 40.5) + 0.286 * lobe(l, 530.9, 16.3, 31.1),
      1.217 * lobe(l, 437.0, 11.8, 36.0) + 0.681 * lobe(l, 459.0, 26.0, 13.8));
}

double planck(double wavelength_nm, double kelvin) {
  constexpr double kSecondRadiation_nm_K = 1.438776877e7;
  return std::pow(wavelength_nm / 560.0, -5.0) / std::expm1(kSecondRadiation_nm_K / (wavelength_nm * kelvin));
}

}  // namespace

dvec3 rec709_from_planck(double kelvin, double wavelength_power) {
  dvec3 c(0.0);
  for (double l = 380.0; l <= 780.0; l += 5.0)
    c += planck(l, kelvin) * std::pow(l / 560.0, wavelength_power) * xyz_of(l);
  c /= c.y;
  return dvec3(3.2406 * c.x - 1.5372 * c.y - 0.4986 * c.z, -0.9689 * c.x + 1.8758 * c.y + 0.0415 * c.z,
               0.0557 * c.x - 0.2040 * c.y + 1.0570 * c.z);
}

double kelvin_from_b_minus_v(double b_minus_v) {
  return 4600.0 * (1.0 / (0.92 * b_minus_v + 1.7) + 1.0 / (0.92 * b_minus_v + 0.62));
}

}  // namespace nepho
