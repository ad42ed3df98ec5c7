#include "atmosphere/spectrum.h"

#include <algorithm>
#include <cmath>

#include "atmosphere/luminance.h"

namespace nepho {

namespace {

// 15 wavelengths and cubic interpolation between them: sunlight through 38 air masses and horizontal light stay within
// 0.2 % of an integral in steps of 1 nm (390..710 nm: 0.35 %; linear interpolation: 2 %; docs/atmosphere.md).
constexpr int kFullCount = kMaxWavelengths;
constexpr double kFirst_nm = 400.0, kLast_nm = 720.0;
constexpr double kStep_nm = (kLast_nm - kFirst_nm) / (kFullCount - 1);

/// Cross sections of ozone, m^2, 360 to 830 nm in steps of 10 (as in Bruneton's demo.cc, from Serdyuchenko et al.
/// 2013).
constexpr std::array<double, 48> kOzoneCrossSection_m2 = {
    1.18e-27,  2.182e-28, 2.818e-28, 6.636e-28, 1.527e-27, 2.763e-27, 5.52e-27,  8.451e-27, 1.582e-26, 2.316e-26,
    3.669e-26, 4.924e-26, 7.752e-26, 9.016e-26, 1.48e-25,  1.602e-25, 2.139e-25, 2.755e-25, 3.091e-25, 3.5e-25,
    4.266e-25, 4.672e-25, 4.398e-25, 4.701e-25, 5.019e-25, 4.305e-25, 3.74e-25,  3.215e-25, 2.662e-25, 2.238e-25,
    1.852e-25, 1.473e-25, 1.209e-25, 9.423e-26, 7.455e-26, 6.566e-26, 5.105e-26, 4.15e-26,  4.228e-26, 3.237e-26,
    2.451e-26, 2.801e-26, 2.534e-26, 1.624e-26, 1.465e-26, 2.078e-26, 1.383e-26, 7.105e-27};

/// 300 Dobson units over a tent of half width 15 km (Bruneton 2017): 300 * 2.687e20 m^-2 / 15 km.
constexpr double kOzonePerCubicMetre = 300.0 * 2.687e20 / 15000.0;

/// Of 300 Dobson units at the tent's top, 1/m.
double standard_ozone_per_m(double wavelength_nm) {
  const double x = std::clamp((wavelength_nm - 360.0) / 10.0, 0.0, 47.0);
  const auto i = std::min(static_cast<size_t>(x), size_t{46});
  const double f = x - static_cast<double>(i);
  return kOzonePerCubicMetre * (kOzoneCrossSection_m2[i] * (1.0 - f) + kOzoneCrossSection_m2[i + 1] * f);
}

/// Of the Earth's air at the ground, 1/m (Bruneton 2017).
double standard_rayleigh_per_m(double wavelength_nm) { return 1.24062e-6 * std::pow(1e-3 * wavelength_nm, -4.0); }

/// A species' spectrum times the ratio of the parameters to it.
template <typename Standard>
double like_standard(const glm::dvec3& values, double wavelength_nm, Standard standard) {
  glm::dvec3 ratio = values;
  for (int c = 0; c < 3; ++c) ratio[c] /= standard(kWavelengths_nm[c]);
  return interpolated_spectrum(ratio, wavelength_nm, false) * standard(wavelength_nm);
}

/// The share of node i in the value at a wavelength: Catmull-Rom between the nodes, with ends continued on a straight
/// line; constant beyond them.
double node_share(int i, double wavelength_nm) {
  const double x = std::clamp((wavelength_nm - kFirst_nm) / kStep_nm, 0.0, kFullCount - 1.0);
  const int j = std::min(static_cast<int>(x), kFullCount - 2);
  const double f = x - j;
  const double cubic[4] = {f * (-0.5 + f * (1.0 - 0.5 * f)), 1.0 + f * f * (-2.5 + 1.5 * f),
                           f * (0.5 + f * (2.0 - 1.5 * f)), f * f * (-0.5 + 0.5 * f)};
  double share = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int node = j - 1 + k;
    const int inner = std::clamp(node, 0, kFullCount - 1);
    const int next = node < 0 ? 1 : kFullCount - 2;
    if (node == inner)
      share += i == node ? cubic[k] : 0.0;
    else  // 2 p(end) - p(next to it)
      share += (i == inner ? 2.0 * cubic[k] : 0.0) - (i == next ? cubic[k] : 0.0);
  }
  return share;
}

void set_rgb_weights(Spectrum& s, const AtmosphereParams& p) {
  for (int i = 0; i < kFullCount; ++i) {
    const auto n = static_cast<size_t>(i);
    // The radiance per sunlight is interpolated; a node without sunlight has the standard sun's weight.
    const bool lit = s.solar_irradiance[n] > 0.0;
    glm::dvec3 sum(0.0);
    for (double nm = kVisibleMin_nm + 0.5; nm < kVisibleMax_nm; nm += 1.0)
      sum += rgb_response(nm) * (node_share(i, nm) * (lit ? solar_irradiance(p, nm) : standard_solar_irradiance(nm)));
    s.rgb[n] = sum / (lit ? s.solar_irradiance[n] : standard_solar_irradiance(s.wavelength_nm[n]));
  }
}

/// Importance of a wavelength in a fit: mostly luminance, some for the colour channels. Sums to 1.
Spectrum::PerWavelength fit_weights(const Spectrum& s) {
  Spectrum::PerWavelength weight{};
  double sum = 0.0;
  for (size_t i = 0; i < kFullCount; ++i) {
    const glm::dvec3 c = s.rgb[i] * standard_solar_irradiance(s.wavelength_nm[i]);
    weight[i] =
        std::abs(0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b) + 0.1 * (std::abs(c.r) + std::abs(c.g) + std::abs(c.b));
    sum += weight[i];
  }
  for (double& w : weight) w /= sum;
  return weight;
}

/// 1, log lambda, its square, and the vertical optical depth of all that is not gas; orthonormal under the weights, so
/// that the fit is a plain projection. Scattering by gas is a straight line in log lambda and its extinction nearly a
/// parabola, so these serve gas on any planet; the last is ozone's bands on the Earth, dust on a planet without.
/// Where that adds nothing (no ozone, no aerosol) it is the cube.
void set_basis(Spectrum& s, const AtmosphereParams& p) {
  const Spectrum::PerWavelength weight = fit_weights(s);
  std::array<Spectrum::PerWavelength, 5> f{};
  for (size_t i = 0; i < kFullCount; ++i) {
    const double x = std::log(s.wavelength_nm[i] / kWavelengths_nm[1]);
    f[0][i] = 1.0;
    f[1][i] = x;
    f[2][i] = x * x;
    f[3][i] = s.ozone_absorption_per_m[i] * p.ozone.half_width_m + s.mie_extinction_per_m[i] * p.mie.scale_height_m;
    f[4][i] = x * x * x;
  }
  const auto dot = [&](const Spectrum::PerWavelength& a, const Spectrum::PerWavelength& b) {
    double sum = 0.0;
    for (size_t i = 0; i < kFullCount; ++i) sum += weight[i] * a[i] * b[i];
    return sum;
  };
  std::array<Spectrum::PerWavelength, kSpectralCoefficients> b{};
  size_t found = 0;
  for (Spectrum::PerWavelength& v : f) {
    if (found == kSpectralCoefficients) break;
    const double before = std::sqrt(dot(v, v));
    for (int pass = 0; pass < 2; ++pass)  // twice: the second removes what rounding left
      for (size_t k = 0; k < found; ++k) {
        const double along = dot(v, b[k]);
        for (size_t i = 0; i < kFullCount; ++i) v[i] -= along * b[k][i];
      }
    const double after = std::sqrt(dot(v, v));
    if (!(after > 1e-6 * before)) continue;
    for (size_t i = 0; i < kFullCount; ++i) b[found][i] = v[i] / after;
    ++found;
  }
  for (size_t k = 0; k < kSpectralCoefficients; ++k)
    for (size_t i = 0; i < kFullCount; ++i) {
      s.basis[i][k] = b[k][i];
      s.fit[k][i] = weight[i] * b[k][i];
    }
}

Spectrum fast_spectrum(const AtmosphereParams& p) {
  Spectrum s;
  const glm::dvec3 factor = sky_luminance_factors();
  for (int c = 0; c < 3; ++c) {
    const auto n = static_cast<size_t>(c);
    s.wavelength_nm[n] = kWavelengths_nm[c];
    s.rayleigh_scattering_per_m[n] = p.rayleigh.scattering_per_m[c];
    s.mie_scattering_per_m[n] = p.mie.scattering_per_m[c];
    s.mie_extinction_per_m[n] = p.mie.extinction_per_m[c];
    s.ozone_absorption_per_m[n] = p.ozone.absorption_per_m[c];
    s.solar_irradiance[n] = p.solar_irradiance_W_m2_nm[c];
    s.rgb[n][c] = factor[c];
    s.basis[n][n] = 1.0;
    s.fit[n][n] = 1.0;
  }
  return s;
}

}  // namespace

Spectrum make_spectrum(const AtmosphereParams& p) {
  if (p.spectral == "fast") return fast_spectrum(p);
  Spectrum s;
  s.groups = kMaxSpectralGroups;
  for (size_t i = 0; i < kFullCount; ++i) {
    const double nm = kFirst_nm + kStep_nm * static_cast<double>(i);
    s.wavelength_nm[i] = nm;
    s.rayleigh_scattering_per_m[i] = like_standard(p.rayleigh.scattering_per_m, nm, standard_rayleigh_per_m);
    s.ozone_absorption_per_m[i] = like_standard(p.ozone.absorption_per_m, nm, standard_ozone_per_m);
    s.mie_extinction_per_m[i] = interpolated_spectrum(p.mie.extinction_per_m, nm, true);
    // Beyond the ends two powers may cross.
    s.mie_scattering_per_m[i] =
        std::min(interpolated_spectrum(p.mie.scattering_per_m, nm, true), s.mie_extinction_per_m[i]);
    s.solar_irradiance[i] = solar_irradiance(p, nm);
  }
  set_rgb_weights(s, p);
  set_basis(s, p);
  return s;
}

}  // namespace nepho
