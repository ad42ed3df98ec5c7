#pragma once
#include <glm/vec3.hpp>

#include "scene/atmosphere_params.h"

namespace nepho {

/// The wavelengths that the tables are computed at, nm: red, green, blue.
inline constexpr double kWavelengths_nm[3] = {680.0, 550.0, 440.0};

/// Factors from spectral radiance at the three wavelengths (W m^-2 sr^-1 nm^-1) to linear Rec. 709 whose luminance is
/// in cd/m^2, one per channel: the spectrum between is taken as the sun's times lambda^power, anchored at the channel's
/// own wavelength (Bruneton 2017). Sun: ASTM G173 extraterrestrial; eye: CIE 1931 2 degrees as fitted by Wyman et al.
/// 2013.
glm::dvec3 luminance_factors(double power);
/// For scattered light: lambda^-3.
glm::dvec3 sky_luminance_factors();
/// For the sun's own light.
glm::dvec3 sun_luminance_factors();

/// The sun on a facing plane at the top of the air, 1 au away: linear Rec. 709 whose luminance is in lux.
glm::vec3 sun_illuminance_at_1au(const AtmosphereParams& params);

}  // namespace nepho
