#pragma once
#include "geo/geodetic.h"

namespace nepho {

/// Linear Rec. 709 (white D65) of luminance 1 of the spectrum planck(kelvin) * wavelength^power; CIE 1931 2 degrees as
/// fitted by Wyman, Sloan and Shirley 2013, 380..780 nm in steps of 5. A negative channel, of a colour outside the
/// gamut, stays negative.
dvec3 rec709_from_planck(double kelvin, double wavelength_power = 0.0);

/// Temperature of a star by its colour index B-V, K (Ballesteros 2012).
double kelvin_from_b_minus_v(double b_minus_v);

}  // namespace nepho
