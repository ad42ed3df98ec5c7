#pragma once
#include "geo/geodetic.h"

namespace nepho {

/// Physical librations, rad: small swings about Cassini's mean state (Meeus 1998, ch. 53, after Eckhardt 1981).
struct PhysicalLibration {
  double inclination = 0.0;  ///< rho: added to the tilt of the moon's equator against the ecliptic
  double node = 0.0;         ///< sigma: shift of the equator's node times the tilt
  double longitude = 0.0;    ///< tau: added to the rotation
};
PhysicalLibration moon_physical_libration(double tt_centuries_since_j2000);

/// Selenographic mean-Earth axes (x to the mean sub-Earth point, y to the moon's east at 90 E, z to its north pole)
/// from the mean ecliptic and equinox of date. Cassini's laws with a tilt of 1.54242 degrees, mean arguments by ERFA,
/// and physical librations; good to about 0.01 degrees (300 m on the moon, 0.2 arc seconds in the sky).
dmat3 moon_body_from_mean_ecliptic(double tt_centuries_since_j2000, const PhysicalLibration& libration);

}  // namespace nepho
