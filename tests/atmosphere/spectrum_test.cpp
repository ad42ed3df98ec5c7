// 15 wavelengths against integrals over the visible spectrum in steps of 1 nm.
#include "atmosphere/spectrum.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "atmosphere/luminance.h"
#include "atmosphere/standard_spectra.h"

using namespace nepho;

namespace {

double luminance(const glm::dvec3& rgb) { return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722)); }

/// Light of the sun after `scatterings` by gas, weakened by columns of surface air, m.
struct Term {
  double amount = 1.0;
  int scatterings = 0;
  double gas_m = 0.0, aerosol_m = 0.0, ozone_m = 0.0;
};

/// An Earth with an aerosol of Angstrom exponent 1.3.
AtmosphereParams earth() {
  AtmosphereParams p;
  for (int c = 0; c < 3; ++c) {
    p.mie.extinction_per_m[c] = 2.5e-5 * std::pow(kWavelengths_nm[c] / 550.0, -1.3);
    p.mie.scattering_per_m[c] = 0.95 * p.mie.extinction_per_m[c];
  }
  return p;
}
AtmosphereParams fast(AtmosphereParams p) {
  p.spectral = "fast";
  return p;
}

double per_sunlight(const std::vector<Term>& light, double gas, double aerosol, double ozone) {
  double sum = 0.0;
  for (const Term& t : light)
    sum += t.amount * std::pow(1e5 * gas, t.scatterings) *
           std::exp(-gas * t.gas_m - aerosol * t.aerosol_m - ozone * t.ozone_m);
  return sum;
}

glm::dvec3 dense(const std::vector<Term>& light) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < 470; ++i) {
    const double nm = 360.5 + i;
    sum += rgb_response(nm) * standard_solar_irradiance(nm) *
           per_sunlight(light, gas_per_m(nm), 2.5e-5 * std::pow(nm / 550.0, -1.3), ozone_per_m(nm));
  }
  return sum;
}

glm::dvec3 by_spectrum(const Spectrum& s, const std::vector<Term>& light) {
  glm::dvec3 sum(0.0);
  for (size_t i = 0; i < static_cast<size_t>(s.count()); ++i)
    sum += s.rgb[i] * s.solar_irradiance[i] *
           per_sunlight(light, s.rayleigh_scattering_per_m[i], s.mie_extinction_per_m[i], s.ozone_absorption_per_m[i]);
  return sum;
}

struct ColourError {
  double luminance;     // relative
  double chromaticity;  // largest difference of a channel, both colours at luminance 1
};
ColourError error_of(const glm::dvec3& found, const glm::dvec3& truth) {
  const double a = luminance(found), b = luminance(truth);
  ColourError e{a / b - 1.0, 0.0};
  for (int c = 0; c < 3; ++c) e.chromaticity = std::max(e.chromaticity, std::abs(found[c] / a - truth[c] / b));
  return e;
}

/// Sunlight through air masses at the ground.
std::vector<Term> sunlight(double air_mass) {
  return {{1.0, 0, 8000.0 * air_mass, 1200.0 * air_mass, 15000.0 * std::min(air_mass, 12.0)}};
}
/// Light from one direction, with so much air between the eye and the far end, and to the sun from either end.
std::vector<Term> single_scattering(double view_mass, double sun_mass) {
  std::vector<Term> light;
  for (int i = 0; i < 40; ++i) {
    const double f = (i + 0.5) / 40.0, mass = view_mass * (1.0 - f) + sun_mass * f;
    light.push_back({1.0 / 40.0, 1, 8000.0 * mass, 1200.0 * mass, 15000.0 * std::min(0.5 * sun_mass, 12.0)});
  }
  return light;
}

/// log(J/E) through the four coefficients and back.
Spectrum::PerWavelength fitted(const Spectrum& s, const Spectrum::PerWavelength& log_light) {
  Spectrum::PerWavelength out{};
  const auto count = static_cast<size_t>(s.count());
  for (size_t k = 0; k < kSpectralCoefficients; ++k) {
    double c = 0.0;
    for (size_t i = 0; i < count; ++i) c += s.fit[k][i] * log_light[i];
    for (size_t i = 0; i < count; ++i) out[i] += c * s.basis[i][k];
  }
  return out;
}

/// Errors of colours after the fit, sorted by luminance, and the worst chromaticity; sums of terms as twilight and day
/// have them.
struct FitErrors {
  std::vector<double> luminance;
  double chromaticity = 0.0;
};
FitErrors fit_errors(const AtmosphereParams& p, double least_mass, double most_mass) {
  const Spectrum s = make_spectrum(p);
  std::mt19937 engine(5);
  const auto unit = [&] { return static_cast<double>(engine()) / 4294967296.0; };
  FitErrors errors;
  for (int n = 0; n < 1000; ++n) {
    const double mass = least_mass * std::pow(most_mass / least_mass, unit());
    std::vector<Term> light;
    for (int terms = 2 + static_cast<int>(5.0 * unit()); terms > 0; --terms) {
      const double air = mass * unit() + 3.0 * unit();
      light.push_back({unit(), static_cast<int>(3.0 * unit()), p.rayleigh.scale_height_m * air,
                       p.mie.scale_height_m * air, p.ozone.half_width_m * std::min(mass, 12.0) * unit()});
    }
    Spectrum::PerWavelength j{};
    for (size_t i = 0; i < 15; ++i)
      j[i] = std::log(
          per_sunlight(light, s.rayleigh_scattering_per_m[i], s.mie_extinction_per_m[i], s.ozone_absorption_per_m[i]));
    const Spectrum::PerWavelength back = fitted(s, j);
    glm::dvec3 truth(0.0), found(0.0);
    for (size_t i = 0; i < 15; ++i) {
      truth += s.rgb[i] * s.solar_irradiance[i] * std::exp(j[i]);
      found += s.rgb[i] * s.solar_irradiance[i] * std::exp(back[i]);
    }
    const ColourError e = error_of(found, truth);
    errors.luminance.push_back(std::abs(e.luminance));
    errors.chromaticity = std::max(errors.chromaticity, e.chromaticity);
  }
  std::sort(errors.luminance.begin(), errors.luminance.end());
  return errors;
}

AtmosphereParams mars() {
  AtmosphereParams p;
  p.rayleigh = {.scattering_per_m = {3.2e-8, 7.5e-8, 1.83e-7}, .scale_height_m = 11000.0};
  p.mie.scattering_per_m = {2.95e-5, 2.75e-5, 2.2e-5};  // iron in the dust absorbs blue
  p.mie.extinction_per_m = {3.05e-5, 3.1e-5, 3.15e-5};
  p.mie.scale_height_m = 11000.0;
  p.ozone.absorption_per_m = glm::dvec3(0.0);
  p.solar_irradiance_W_m2_nm *= 0.43;
  return p;
}

}  // namespace

TEST_CASE("15 wavelengths give the colour of sunlight through 1 to 38 air masses to 0.25 % and 0.003") {
  const Spectrum s = make_spectrum(earth()), three = make_spectrum(fast(earth()));
  for (const double mass : {1.0, 5.0, 20.0, 38.0}) {
    const glm::dvec3 truth = dense(sunlight(mass));
    const ColourError e = error_of(by_spectrum(s, sunlight(mass)), truth);
    CHECK(std::abs(e.luminance) < 0.0025);
    CHECK(e.chromaticity < 0.003);
    // Three wavelengths, with the factors of sunlight.
    const glm::dvec3 sun_factor = sun_luminance_factors();
    glm::dvec3 rough(0.0);
    for (int c = 0; c < 3; ++c) {
      const auto n = static_cast<size_t>(c);
      rough[c] = sun_factor[c] * three.solar_irradiance[n] *
                 per_sunlight(sunlight(mass), three.rayleigh_scattering_per_m[n], three.mie_extinction_per_m[n],
                              three.ozone_absorption_per_m[n]);
    }
    const ColourError f = error_of(rough, truth);
    MESSAGE("air mass " << mass << ": full " << 100.0 * e.luminance << " %, " << e.chromaticity << "; fast "
                        << 100.0 * f.luminance << " %, " << f.chromaticity);
  }
}

TEST_CASE("15 wavelengths give the colour of light scattered once to 0.25 % and 0.003, at noon and at sunset") {
  const Spectrum s = make_spectrum(earth()), three = make_spectrum(fast(earth()));
  for (const double view_mass : {1.0, 38.0})
    for (const double sun_mass : {1.0, 2.0, 10.0, 30.0}) {
      const auto light = single_scattering(view_mass, sun_mass);
      const ColourError e = error_of(by_spectrum(s, light), dense(light));
      CHECK(std::abs(e.luminance) < 0.0025);
      CHECK(e.chromaticity < 0.003);
      const ColourError f = error_of(by_spectrum(three, light), dense(light));
      MESSAGE("view " << view_mass << ", sun " << sun_mass << ": full " << 100.0 * e.luminance << " %, "
                      << e.chromaticity << "; fast " << 100.0 * f.luminance << " %, " << f.chromaticity);
    }
}

TEST_CASE("the weights of the 15 wavelengths add up to the sun above the air, also another planet's") {
  for (const AtmosphereParams& p : {earth(), mars()}) {
    const Spectrum s = make_spectrum(p);
    glm::dvec3 sum(0.0);
    for (size_t i = 0; i < 15; ++i) sum += s.rgb[i] * s.solar_irradiance[i];
    for (int c = 0; c < 3; ++c) CHECK(sum[c] == doctest::Approx(sun_illuminance_at_1au(p)[c]).epsilon(1e-6));
  }
}

TEST_CASE("the spectra pass through the parameters") {
  for (const AtmosphereParams& p : {earth(), mars()}) {
    const Spectrum s = make_spectrum(p);
    CHECK(s.count() == 15);
    // 560 nm is a wavelength; gas, aerosol and sun are near their value at 550 nm times a power law.
    CHECK(s.wavelength_nm[7] == doctest::Approx(560.0));
    const double x = std::log(560.0 / 550.0) / std::log(680.0 / 550.0);
    CHECK(s.rayleigh_scattering_per_m[7] ==
          doctest::Approx(p.rayleigh.scattering_per_m[1] *
                          std::pow(p.rayleigh.scattering_per_m[0] / p.rayleigh.scattering_per_m[1], x)));
    CHECK(s.mie_extinction_per_m[7] ==
          doctest::Approx(p.mie.extinction_per_m[1] *
                          std::pow(p.mie.extinction_per_m[0] / p.mie.extinction_per_m[1], x)));
    for (size_t i = 0; i < 15; ++i) {
      CHECK(s.mie_scattering_per_m[i] <= s.mie_extinction_per_m[i]);
      CHECK(s.solar_irradiance[i] == doctest::Approx(solar_irradiance(p, s.wavelength_nm[i])));
    }
  }
  // The Earth's ozone is the laboratory's.
  const Spectrum s = make_spectrum(earth());
  for (size_t i = 0; i < 15; ++i)
    CHECK(s.ozone_absorption_per_m[i] == doctest::Approx(ozone_per_m(s.wavelength_nm[i])).epsilon(1e-4));
}

TEST_CASE("fast has the parameters themselves, and one coefficient each") {
  const AtmosphereParams p = fast(mars());
  const Spectrum s = make_spectrum(p);
  CHECK(s.groups == 1);
  Spectrum::PerWavelength j{};
  for (size_t i = 0; i < 3; ++i) {
    const int c = static_cast<int>(i);
    CHECK(s.wavelength_nm[i] == kWavelengths_nm[i]);
    CHECK(s.mie_scattering_per_m[i] == p.mie.scattering_per_m[c]);
    CHECK(s.rgb[i][c] == sky_luminance_factors()[c]);
    CHECK(s.rgb[i][(c + 1) % 3] == 0.0);
    j[i] = -1.0 - static_cast<double>(i);
  }
  CHECK(fitted(s, j) == j);
}

TEST_CASE("a spectrum of four coefficients comes back from its fit, whatever the air lacks") {
  AtmosphereParams no_ozone = earth(), no_aerosol = earth(), gas_alone = earth(), none = earth();
  for (AtmosphereParams* p : {&no_ozone, &gas_alone, &none}) p->ozone.absorption_per_m = glm::dvec3(0.0);
  for (AtmosphereParams* p : {&no_aerosol, &gas_alone, &none})
    p->mie.extinction_per_m = p->mie.scattering_per_m = glm::dvec3(0.0);
  none.rayleigh.scattering_per_m = glm::dvec3(0.0);
  AtmosphereParams dark = earth();
  dark.solar_irradiance_W_m2_nm = glm::dvec3(0.0);
  for (const AtmosphereParams& p : {earth(), mars(), no_ozone, no_aerosol, gas_alone, none, dark}) {
    const Spectrum s = make_spectrum(p);
    Spectrum::PerWavelength j{};
    for (size_t i = 0; i < 15; ++i) {
      const double c[4] = {-7.0, 1.5, -0.4, 0.7};
      for (size_t k = 0; k < 4; ++k) j[i] += c[k] * s.basis[i][k];
      CHECK(std::isfinite(glm::dot(s.rgb[i], s.rgb[i])));
    }
    const Spectrum::PerWavelength back = fitted(s, j);
    for (size_t i = 0; i < 15; ++i) CHECK(back[i] == doctest::Approx(j[i]).epsilon(1e-9));
  }
  for (const double v : make_spectrum(gas_alone).ozone_absorption_per_m) CHECK(v == 0.0);
  for (const double v : make_spectrum(gas_alone).mie_extinction_per_m) CHECK(v == 0.0);
  for (const double v : make_spectrum(none).rayleigh_scattering_per_m) CHECK(v == 0.0);
}

TEST_CASE("four coefficients keep the luminance of sky light to 0.2 % and its colour to 0.03, by day and by twilight") {
  const FitErrors day = fit_errors(earth(), 0.3, 5.0), twilight = fit_errors(earth(), 5.0, 40.0);
  MESSAGE("day: median " << day.luminance[500] << ", worst " << day.luminance.back() << ", " << day.chromaticity);
  MESSAGE("twilight: median " << twilight.luminance[500] << ", worst " << twilight.luminance.back() << ", "
                              << twilight.chromaticity);
  CHECK(day.luminance[500] < 0.0005);
  CHECK(day.luminance.back() < 0.002);
  CHECK(day.chromaticity < 0.03);
  CHECK(twilight.luminance[500] < 0.0005);
  CHECK(twilight.luminance.back() < 0.002);
  CHECK(twilight.chromaticity < 0.03);
}

TEST_CASE("four coefficients keep the light of a dusty planet to 0.2 % and 0.03 as well") {
  const FitErrors day = fit_errors(mars(), 0.3, 5.0);
  MESSAGE("dust: median " << day.luminance[500] << ", worst " << day.luminance.back() << ", " << day.chromaticity);
  CHECK(day.luminance.back() < 0.002);
  CHECK(day.chromaticity < 0.03);
}
