#include "atmosphere/luminance.h"

#include <algorithm>
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

/// CIE 1931 2 degree observer, x, y, z of 360 to 830 nm in steps of 5.
constexpr std::array<double, 285> kObserver = {0.0001299,    3.917e-06,  0.0006061,
                                               0.0002321,    6.965e-06,  0.001086,
                                               0.0004149,    1.239e-05,  0.001946,
                                               0.0007416,    2.202e-05,  0.003486,
                                               0.001368,     3.9e-05,    0.00645,
                                               0.002236,     6.4e-05,    0.01055,
                                               0.004243,     0.00012,    0.02005,
                                               0.00765,      0.000217,   0.03621,
                                               0.01431,      0.000396,   0.06785,
                                               0.02319,      0.00064,    0.1102,
                                               0.04351,      0.00121,    0.2074,
                                               0.07763,      0.00218,    0.3713,
                                               0.13438,      0.004,      0.6456,
                                               0.21477,      0.0073,     1.03905,
                                               0.2839,       0.0116,     1.3856,
                                               0.3285,       0.01684,    1.62296,
                                               0.34828,      0.023,      1.74706,
                                               0.34806,      0.0298,     1.7826,
                                               0.3362,       0.038,      1.77211,
                                               0.3187,       0.048,      1.7441,
                                               0.2908,       0.06,       1.6692,
                                               0.2511,       0.0739,     1.5281,
                                               0.19536,      0.09098,    1.28764,
                                               0.1421,       0.1126,     1.0419,
                                               0.09564,      0.13902,    0.8129501,
                                               0.05795001,   0.1693,     0.6162,
                                               0.03201,      0.20802,    0.46518,
                                               0.0147,       0.2586,     0.3533,
                                               0.0049,       0.323,      0.272,
                                               0.0024,       0.4073,     0.2123,
                                               0.0093,       0.503,      0.1582,
                                               0.0291,       0.6082,     0.1117,
                                               0.06327,      0.71,       0.07824999,
                                               0.1096,       0.7932,     0.05725001,
                                               0.1655,       0.862,      0.04216,
                                               0.2257499,    0.9148501,  0.02984,
                                               0.2904,       0.954,      0.0203,
                                               0.3597,       0.9803,     0.0134,
                                               0.4334499,    0.9949501,  0.008749999,
                                               0.5120501,    1,          0.005749999,
                                               0.5945,       0.995,      0.0039,
                                               0.6784,       0.9786,     0.002749999,
                                               0.7621,       0.952,      0.0021,
                                               0.8425,       0.9154,     0.0018,
                                               0.9163,       0.87,       0.001650001,
                                               0.9786,       0.8163,     0.0014,
                                               1.0263,       0.757,      0.0011,
                                               1.0567,       0.6949,     0.001,
                                               1.0622,       0.631,      0.0008,
                                               1.0456,       0.5668,     0.0006,
                                               1.0026,       0.503,      0.00034,
                                               0.9384,       0.4412,     0.00024,
                                               0.8544499,    0.381,      0.00019,
                                               0.7514,       0.321,      0.0001,
                                               0.6424,       0.265,      4.999999e-05,
                                               0.5419,       0.217,      3e-05,
                                               0.4479,       0.175,      2e-05,
                                               0.3608,       0.1382,     1e-05,
                                               0.2835,       0.107,      0,
                                               0.2187,       0.0816,     0,
                                               0.1649,       0.061,      0,
                                               0.1212,       0.04458,    0,
                                               0.0874,       0.032,      0,
                                               0.0636,       0.0232,     0,
                                               0.04677,      0.017,      0,
                                               0.0329,       0.01192,    0,
                                               0.0227,       0.00821,    0,
                                               0.01584,      0.005723,   0,
                                               0.01135916,   0.004102,   0,
                                               0.008110916,  0.002929,   0,
                                               0.005790346,  0.002091,   0,
                                               0.004109457,  0.001484,   0,
                                               0.002899327,  0.001047,   0,
                                               0.00204919,   0.00074,    0,
                                               0.001439971,  0.00052,    0,
                                               0.0009999493, 0.0003611,  0,
                                               0.0006900786, 0.0002492,  0,
                                               0.0004760213, 0.0001719,  0,
                                               0.0003323011, 0.00012,    0,
                                               0.0002348261, 8.48e-05,   0,
                                               0.0001661505, 6e-05,      0,
                                               0.000117413,  4.24e-05,   0,
                                               8.307527e-05, 3e-05,      0,
                                               5.870652e-05, 2.12e-05,   0,
                                               4.150994e-05, 1.499e-05,  0,
                                               2.935326e-05, 1.06e-05,   0,
                                               2.067383e-05, 7.4657e-06, 0,
                                               1.455977e-05, 5.2578e-06, 0,
                                               1.025398e-05, 3.7029e-06, 0,
                                               7.221456e-06, 2.6078e-06, 0,
                                               5.085868e-06, 1.8366e-06, 0,
                                               3.581652e-06, 1.2934e-06, 0,
                                               2.522525e-06, 9.1093e-07, 0,
                                               1.776509e-06, 6.4153e-07, 0,
                                               1.251141e-06, 4.5181e-07, 0};

glm::dvec3 xyz_of(double wavelength_nm) {
  const double x = (wavelength_nm - kVisibleMin_nm) / 5.0;
  if (!(x >= 0.0 && x <= 94.0)) return glm::dvec3(0.0);
  const auto i = std::min(static_cast<size_t>(x), size_t{93});
  const double f = x - static_cast<double>(i);
  const double *a = &kObserver[3 * i], *b = a + 3;
  return glm::dvec3(a[0], a[1], a[2]) * (1.0 - f) + glm::dvec3(b[0], b[1], b[2]) * f;
}

/// Linear Rec. 709, white point D65.
glm::dvec3 rgb_from_xyz(const glm::dvec3& c) {
  return glm::dvec3(3.2406 * c.x - 1.5372 * c.y - 0.4986 * c.z, -0.9689 * c.x + 1.8758 * c.y + 0.0415 * c.z,
                    0.0557 * c.x - 0.2040 * c.y + 1.0570 * c.z);
}

}  // namespace

double standard_solar_irradiance(double wavelength_nm) {
  const double x = std::clamp((wavelength_nm - 360.0) / 10.0, 0.0, 47.0);
  const auto i = std::min(static_cast<size_t>(x), size_t{46});
  const double f = x - static_cast<double>(i);
  return kSolarIrradiance[i] * (1.0 - f) + kSolarIrradiance[i + 1] * f;
}

double solar_irradiance(const AtmosphereParams& params, double wavelength_nm) {
  glm::dvec3 ratio = params.solar_irradiance_W_m2_nm;
  for (int c = 0; c < 3; ++c) ratio[c] /= standard_solar_irradiance(kWavelengths_nm[c]);
  return interpolated_spectrum(ratio, wavelength_nm, false) * standard_solar_irradiance(wavelength_nm);
}

glm::dvec3 rgb_response(double wavelength_nm) {
  return kMaxLuminousEfficacy_lm_W * rgb_from_xyz(xyz_of(wavelength_nm));
}

double interpolated_spectrum(const glm::dvec3& values, double wavelength_nm, bool extrapolate) {
  const int red = wavelength_nm > kWavelengths_nm[1] ? 0 : 1;  // the interval's end of longer wavelength
  const double a = values[red], b = values[red + 1];
  const double la = std::log(kWavelengths_nm[red]), lb = std::log(kWavelengths_nm[red + 1]);
  const double f = (std::log(wavelength_nm) - la) / (lb - la);
  const bool power = a > 0.0 && b > 0.0;
  if (f <= 0.0 && !(power && extrapolate)) return a;
  if (f >= 1.0 && !(power && extrapolate)) return b;
  return power ? a * std::pow(b / a, f) : a + (b - a) * f;
}

glm::dvec3 luminance_factors(double power) {
  glm::dvec3 sum(0.0);
  for (double nm = kVisibleMin_nm + 0.5; nm < kVisibleMax_nm; nm += 1.0) {
    const glm::dvec3 rgb = rgb_response(nm);
    for (int c = 0; c < 3; ++c)
      sum[c] += rgb[c] * standard_solar_irradiance(nm) / standard_solar_irradiance(kWavelengths_nm[c]) *
                std::pow(nm / kWavelengths_nm[c], power);
  }
  return sum;
}

glm::dvec3 sky_luminance_factors() { return luminance_factors(-3.0); }
glm::dvec3 sun_luminance_factors() { return luminance_factors(0.0); }

glm::vec3 sun_illuminance_at_1au(const AtmosphereParams& params) {
  if (params.spectral == "fast") return glm::vec3(sun_luminance_factors() * params.solar_irradiance_W_m2_nm);
  glm::dvec3 sum(0.0);
  for (double nm = kVisibleMin_nm + 0.5; nm < kVisibleMax_nm; nm += 1.0)
    sum += rgb_response(nm) * solar_irradiance(params, nm);
  return glm::vec3(sum);
}

}  // namespace nepho
