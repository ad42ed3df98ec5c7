#pragma once
#include "geo/geodetic.h"

namespace nepho {

/// Light of the moon over the light of the sun at 1 au, both on a facing plane at the observer, in luminance. From
/// Allen's magnitude of the moon (Astrophysical Quantities, 3rd ed., section 66) V = -12.73 + 0.026 |a| + 4e-9 a^4, a
/// the phase angle in degrees, at the mean distance and 1 au from the sun, against V = -26.74 of the sun; scaled by
/// both distances. Past 150 degrees, where the measurements end, it goes on as a Lommel-Seeliger sphere does, to 0 at
/// new moon. Full moon: 2.49e-6, 1 / 402,000. The surge within 5 degrees of full moon (up to a third) is not in the
/// formula.
double moon_sun_illuminance_ratio(double phase_angle_rad, double moon_distance_m, double sun_moon_distance_au);

/// Light of the lit Earth on a facing plane at the moon, over the light of the sun at 1 au. The Earth as a Lambert
/// sphere of geometric albedo 0.367; seen from the moon its phase is the complement of the moon's.
double earthshine_illuminance_ratio(double moon_phase_angle_rad, double earth_moon_distance_m,
                                    double sun_earth_distance_au);

/// Lambert sphere: brightness at a phase angle over that at full phase (Russell 1916).
double lambert_phase(double phase_angle_rad);

/// Factors from sunlight to moonlight of the same luminance, linear Rec. 709: the sun reflected with an albedo that
/// grows with wavelength as B-V says (moon 0.92, sun 0.65).
dvec3 moonlight_color();
/// The same for sunlight that came by the Earth and then the moon: bluer than moonlight by 0.17 in B-V (Franklin 1967).
dvec3 earthshine_color();

}  // namespace nepho
