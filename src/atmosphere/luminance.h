#pragma once
#include <glm/vec3.hpp>

#include "scene/atmosphere_params.h"

namespace nepho {

/// The wavelengths that parameters are given at, nm: red, green, blue.
inline constexpr double kWavelengths_nm[3] = {680.0, 550.0, 440.0};

/// The wavelengths that the eye sees, nm.
inline constexpr double kVisibleMin_nm = 360.0;
inline constexpr double kVisibleMax_nm = 830.0;

/// The sun at 1 au above the air, W m^-2 nm^-1: ASTM G173 extraterrestrial, in steps of 10 nm as in Bruneton 2017.
/// Constant beyond 360..830 nm.
double standard_solar_irradiance(double wavelength_nm);

/// The same, through other values at 680, 550 and 440 nm: their ratio to the standard is a power of the wavelength
/// between them and constant beyond.
double solar_irradiance(const AtmosphereParams& params, double wavelength_nm);

/// Linear Rec. 709 (white point D65), luminance in lm, of 1 W at a wavelength: CIE 1931 2 degree observer. 0 beyond
/// 360..830 nm.
glm::dvec3 rgb_response(double wavelength_nm);

/// `values` at 680, 550 and 440 nm, all >= 0, as a power of the wavelength between them, and beyond them constant or,
/// with `extrapolate`, with the outer power. Next to a 0, where there is no power: linear in the wavelength's
/// logarithm.
double interpolated_spectrum(const glm::dvec3& values, double wavelength_nm, bool extrapolate);

/// Factors from spectral radiance at the three wavelengths (W m^-2 sr^-1 nm^-1) to linear Rec. 709 whose luminance is
/// in cd/m^2, one per channel: the spectrum between is taken as the sun's times lambda^power, anchored at the channel's
/// own wavelength (Bruneton 2017).
glm::dvec3 luminance_factors(double power);
/// For scattered light: lambda^-3.
glm::dvec3 sky_luminance_factors();
/// For the sun's own light.
glm::dvec3 sun_luminance_factors();

/// The sun on a facing plane at the top of the air, 1 au away: linear Rec. 709 whose luminance is in lux.
glm::vec3 sun_illuminance_at_1au(const AtmosphereParams& params);

}  // namespace nepho
