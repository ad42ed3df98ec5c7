#pragma once
#include <array>
#include <glm/vec3.hpp>

#include "scene/atmosphere_params.h"

namespace nepho {

inline constexpr int kMaxSpectralGroups = 5;
inline constexpr int kMaxWavelengths = 3 * kMaxSpectralGroups;
/// Numbers that stand for a spectrum of multiply scattered light.
inline constexpr int kSpectralCoefficients = 4;

/// The wavelengths that light is computed at, in groups of three, and how they become colours (docs/atmosphere.md).
/// Entries beyond `count()` are 0.
struct Spectrum {
  using PerWavelength = std::array<double, kMaxWavelengths>;

  int groups = 1;  ///< 1 (`spectral: fast`: 680, 550, 440 nm) or 5 (`full`: 400 to 720 nm, evenly spaced)
  int count() const { return 3 * groups; }

  PerWavelength wavelength_nm{};
  PerWavelength rayleigh_scattering_per_m{};  ///< at height 0
  PerWavelength mie_scattering_per_m{};       ///< at height 0
  PerWavelength mie_extinction_per_m{};       ///< at height 0
  PerWavelength ozone_absorption_per_m{};     ///< at the tent's top
  PerWavelength solar_irradiance{};           ///< W m^-2 nm^-1, at 1 au, above the air

  /// What spectral radiance at a wavelength (W m^-2 sr^-1 nm^-1) adds to linear Rec. 709 whose luminance is in cd/m^2,
  /// for light whose spectrum is smooth relative to the sun's. May be negative: the colour of one wavelength is outside
  /// Rec. 709.
  std::array<glm::dvec3, kMaxWavelengths> rgb{};

  /// A spectrum J as coefficients c: log(J / E_sun)(lambda_i) = sum_k c_k basis[i][k]. Its best approximation has
  /// c_k = sum_i fit[k][i] log(J_i / E_i). fast: each of the first three coefficients is one wavelength's, exactly.
  std::array<std::array<double, kSpectralCoefficients>, kMaxWavelengths> basis{};
  std::array<PerWavelength, kSpectralCoefficients> fit{};
};

/// The spectrum of air whose coefficients are resolved (scene/atmosphere_params.h); `spectral` chooses the mode.
///
/// Parameters give 680, 550 and 440 nm. At the wavelengths of `full`, gas, ozone and sun have the spectra of the
/// Earth's (Bruneton 2017, demo) times the ratio of the parameters to them: interpolated as powers of the wavelength,
/// constant beyond the ends. Aerosol is a power of the wavelength between the three and beyond them.
Spectrum make_spectrum(const AtmosphereParams& resolved_params);

}  // namespace nepho
