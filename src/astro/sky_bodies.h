#pragma once
#include <optional>

#include "astro/utc_time.h"
#include "geo/geodetic.h"

namespace nepho {

inline constexpr double kAstronomicalUnit_m = 149597870700.0;  ///< IAU 2012
inline constexpr double kSunRadius_m = 695700e3;               ///< IAU 2015 nominal
inline constexpr double kMoonRadius_m = 1737.4e3;              ///< IAU mean

/// The sun from the Earth's centre.
struct SunState {
  dvec3 dir_ecef{1.0, 0.0, 0.0};    ///< unit, towards the apparent sun (light time and aberration included)
  double distance_au = 1.0;         ///< from the Earth's centre
  double angular_radius_rad = 0.0;  ///< asin(radius / distance)
};

/// The moon from the Earth's centre.
struct MoonState {
  dvec3 dir_ecef{1.0, 0.0, 0.0};            ///< unit, towards the moon, geometric (light time is 0.7 arc seconds)
  double distance_m = 0.0;                  ///< from the Earth's centre
  double angular_radius_rad = 0.0;          ///< asin(radius / distance)
  double illuminated_fraction = 0.0;        ///< of the disc, 0 new .. 1 full
  double phase_angle_rad = 0.0;             ///< sun - moon - Earth, 0 full .. pi new
  double ecliptic_elongation_rad = 0.0;     ///< longitude of the moon less the sun's, [0, 2 pi): 0 new, pi full
  dvec3 sun_from_moon_ecef{1.0, 0.0, 0.0};  ///< unit, from the moon towards the sun
  double sun_distance_au = 1.0;             ///< from the moon to the sun
  dmat3 body_from_ecef{1.0};                ///< selenographic axes from ECEF ones (moon_orientation.h)
};

/// Everything that turns with the Earth at one moment. Axes: ECEF as TIRS, polar motion (<= 0.5 arc seconds) neglected.
struct SkyBodies {
  SunState sun;
  MoonState moon;
  dmat3 ecef_from_icrs{1.0};   ///< turns star catalogue directions (ICRS) into ECEF: precession, nutation, rotation
  double gast_rad = 0.0;       ///< Greenwich apparent sidereal time, [0, 2 pi)
  double tt_minus_ut_s = 0.0;  ///< as used
};

/// Sun, moon and stars at a moment, by ERFA: eraEpv00 + eraAb for the sun (about 2 arc seconds), eraMoon98 for the moon
/// (9), IAU 2006/2000A precession-nutation and eraGst06. `tt_minus_ut_s` overrides time_scales.h.
SkyBodies sky_bodies_at(const UtcInstant& utc, std::optional<double> tt_minus_ut_s = std::nullopt);

/// A body as seen from a place, without refraction.
struct Horizontal {
  double elevation_rad = 0.0;  ///< above the plane perpendicular to the geodetic vertical, -pi/2..pi/2
  double azimuth_rad = 0.0;    ///< from north through east, [0, 2 pi)
  double distance_m = 0.0;     ///< from the observer
};

/// Elevation and azimuth of a point given by direction and distance from the Earth's centre: parallax included.
Horizontal horizontal_from_ecef(const Geodetic& observer, const dvec3& dir_ecef, double distance_m);

}  // namespace nepho
