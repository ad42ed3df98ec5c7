#include "atmosphere/luminance.h"

#include <array>
#include <cmath>

namespace nepho {

namespace {

constexpr double kMaxLuminousEfficacy_lm_W = 683.0;

/// ASTM G173 extraterrestrial, W m^-2 nm^-1, 360 to 830 nm in steps of 10 (as in Bruneton's demo.cc).
constexpr std::array<double, 48> kSolarIrradiance = {
    1.11776, 1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.6887,  1.61253, 1.91198, 2.03474, 2.02042, 2.02212,
    1.93377, 1.95809, 1.91686, 1.8298,  1.8685,  1.8931,  1.85149, 1.8504,  1.8341,  1.8345,  1.8147,  1.78158,
    1.7533,  1.6965,  1.68194, 1.64654, 1.6048,  1.52143, 1.55622, 1.5113,  1.474,   1.4482,  1.41018, 1.36775,
    1.34188, 1.31429, 1.28303, 1.26758, 1.2367,  1.2082,  1.18737, 1.14683, 1.12362, 1.1058,  1.07124, 1.04992};

double solar_irradiance(double wavelength_nm) {
  const double x = std::min(std::max((wavelength_nm - 360.0) / 10.0, 0.0), 46.999);
  const auto i = static_cast<size_t>(x);
  const double f = x - static_cast<double>(i);
  return kSolarIrradiance[i] * (1.0 - f) + kSolarIrradiance[i + 1] * f;
}

/// A Gaussian with one width below its centre and another above.
double lobe(double wavelength_nm, double centre, double below, double above) {
  const double t = (wavelength_nm - centre) / (wavelength_nm < centre ? below : above);
  return std::exp(-0.5 * t * t);
}

/// Wyman, Sloan, Shirley 2013, multi-lobe fit of the CIE 1931 2 degree observer.
glm::dvec3 xyz_of(double l) {
  return glm::dvec3(
      1.056 * lobe(l, 599.8, 37.9, 31.0) + 0.362 * lobe(l, 442.0, 16.0, 26.7) - 0.065 * lobe(l, 501.1, 20.4, 26.2),
      0.821 * lobe(l, 568.8, 46.9, 40.5) + 0.286 * lobe(l, 530.9, 16.3, 31.1),
      1.217 * lobe(l, 437.0, 11.8, 36.0) + 0.681 * lobe(l, 459.0, 26.0, 13.8));
}

/// Linear Rec. 709, white point D65.
glm::dvec3 rgb_from_xyz(const glm::dvec3& c) {
  return glm::dvec3(3.2406 * c.x - 1.5372 * c.y - 0.4986 * c.z, -0.9689 * c.x + 1.8758 * c.y + 0.0415 * c.z,
                    0.0557 * c.x - 0.2040 * c.y + 1.0570 * c.z);
}

}  // namespace

glm::dvec3 luminance_factors(double power) {
  glm::dvec3 sum(0.0);
  for (int nm = 360; nm < 830; ++nm) {
    const double wavelength = nm + 0.5;
    const glm::dvec3 rgb = rgb_from_xyz(xyz_of(wavelength));
    for (int c = 0; c < 3; ++c)
      sum[c] += rgb[c] * solar_irradiance(wavelength) / solar_irradiance(kWavelengths_nm[c]) *
                std::pow(wavelength / kWavelengths_nm[c], power);
  }
  return kMaxLuminousEfficacy_lm_W * sum;
}

glm::dvec3 sky_luminance_factors() { return luminance_factors(-3.0); }
glm::dvec3 sun_luminance_factors() { return luminance_factors(0.0); }

glm::vec3 sun_illuminance_at_1au(const AtmosphereParams& params) {
  return glm::vec3(sun_luminance_factors() * params.solar_irradiance_W_m2_nm);
}

}  // namespace nepho
