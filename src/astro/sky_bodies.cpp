#include "astro/sky_bodies.h"

#include <erfa.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "astro/moon_orientation.h"
#include "astro/time_scales.h"
#include "geo/frames.h"

namespace nepho {

namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kLightDaysPerAu = 499.004783836 / 86400.0;
constexpr double kEpoch2000Jd = 2451544.5;  // 2000-01-01T00:00

/// A two-part Julian date as ERFA takes it: the big part first.
struct JulianDate {
  double whole, part;
};

dmat3 from_rows(const double (&m)[3][3]) {
  return glm::transpose(
      dmat3(dvec3(m[0][0], m[0][1], m[0][2]), dvec3(m[1][0], m[1][1], m[1][2]), dvec3(m[2][0], m[2][1], m[2][2])));
}

dvec3 vec_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Apparent sun from the Earth's centre in GCRS axes: unit direction and distance.
struct ApparentSun {
  dvec3 dir_gcrs;
  double distance_au;
};

ApparentSun apparent_sun(const JulianDate& tt) {
  double heliocentric[2][3], barycentric[2][3];
  // TDB is taken as TT: 2 ms, in which the Earth moves 60 m. The status only says that 1900..2100 was left.
  eraEpv00(tt.whole, tt.part, heliocentric, barycentric);
  const dvec3 earth = vec_of(barycentric[0]), velocity_au_per_day = vec_of(barycentric[1]);
  const double now_au = glm::length(vec_of(heliocentric[0]));
  // The sun where it was when the light left it.
  double heliocentric_then[2][3], barycentric_then[2][3];
  eraEpv00(tt.whole, tt.part - now_au * kLightDaysPerAu, heliocentric_then, barycentric_then);
  const dvec3 sun_then = vec_of(barycentric_then[0]) - vec_of(heliocentric_then[0]);
  const dvec3 towards = sun_then - earth;
  const double distance_au = glm::length(towards);

  const dvec3 natural = towards / distance_au;
  const dvec3 beta = velocity_au_per_day * kLightDaysPerAu;  // in units of the speed of light
  double natural_direction[3] = {natural.x, natural.y, natural.z};
  double velocity_c[3] = {beta.x, beta.y, beta.z};
  double proper[3];
  eraAb(natural_direction, velocity_c, now_au, std::sqrt(1.0 - glm::dot(beta, beta)), proper);
  return {glm::normalize(vec_of(proper)), distance_au};
}

double positive_angle(double rad) {
  const double turned = std::fmod(rad, kTwoPi);
  const double positive = turned < 0.0 ? turned + kTwoPi : turned;
  return positive < kTwoPi ? positive : 0.0;  // -1e-20 rounds up to a whole turn
}

}  // namespace

SkyBodies sky_bodies_at(const UtcInstant& utc, std::optional<double> tt_minus_ut_s) {
  SkyBodies sky;
  sky.tt_minus_ut_s = tt_minus_ut_s ? *tt_minus_ut_s : nepho::tt_minus_ut_s(utc);
  const JulianDate ut{kEpoch2000Jd + static_cast<double>(utc.day), utc.second_of_day / 86400.0};
  const JulianDate tt{ut.whole, ut.part + sky.tt_minus_ut_s / 86400.0};

  double true_from_gcrs[3][3];
  eraPnm06a(tt.whole, tt.part, true_from_gcrs);
  sky.gast_rad = eraGst06(ut.whole, ut.part, tt.whole, tt.part, true_from_gcrs);
  const double c = std::cos(sky.gast_rad), s = std::sin(sky.gast_rad);
  const dmat3 ecef_from_true(dvec3(c, -s, 0.0), dvec3(s, c, 0.0), dvec3(0.0, 0.0, 1.0));
  sky.ecef_from_icrs = ecef_from_true * from_rows(true_from_gcrs);

  const ApparentSun sun = apparent_sun(tt);
  sky.sun.dir_ecef = sky.ecef_from_icrs * sun.dir_gcrs;
  sky.sun.distance_au = sun.distance_au;
  sky.sun.angular_radius_rad = std::asin(kSunRadius_m / (sun.distance_au * kAstronomicalUnit_m));

  double moon_au[2][3];
  eraMoon98(tt.whole, tt.part, moon_au);
  const dvec3 moon = vec_of(moon_au[0]);
  const double moon_distance_au = glm::length(moon);
  sky.moon.dir_ecef = sky.ecef_from_icrs * (moon / moon_distance_au);
  sky.moon.distance_m = moon_distance_au * kAstronomicalUnit_m;
  sky.moon.angular_radius_rad = std::asin(kMoonRadius_m / sky.moon.distance_m);
  const dvec3 towards_sun = sun.dir_gcrs * sun.distance_au - moon;
  sky.moon.sun_distance_au = glm::length(towards_sun);
  const dvec3 sun_from_moon = towards_sun / sky.moon.sun_distance_au;
  sky.moon.sun_from_moon_ecef = sky.ecef_from_icrs * sun_from_moon;
  const double cos_phase = std::clamp(glm::dot(sun_from_moon, -moon / moon_distance_au), -1.0, 1.0);
  sky.moon.phase_angle_rad = std::acos(cos_phase);
  sky.moon.illuminated_fraction = 0.5 * (1.0 + cos_phase);

  double ecliptic_from_gcrs[3][3];
  eraEcm06(tt.whole, tt.part, ecliptic_from_gcrs);
  const dmat3 ecliptic = from_rows(ecliptic_from_gcrs);
  const double centuries = (tt.whole - 2451545.0 + tt.part) / 36525.0;
  sky.moon.body_from_ecef = moon_body_from_mean_ecliptic(centuries, moon_physical_libration(centuries)) * ecliptic *
                            glm::transpose(sky.ecef_from_icrs);
  const dvec3 sun_ecliptic = ecliptic * sun.dir_gcrs, moon_ecliptic = ecliptic * moon;
  sky.moon.ecliptic_elongation_rad =
      positive_angle(std::atan2(moon_ecliptic.y, moon_ecliptic.x) - std::atan2(sun_ecliptic.y, sun_ecliptic.x));
  return sky;
}

Horizontal horizontal_from_ecef(const Geodetic& observer, const dvec3& dir_ecef, double distance_m) {
  const dvec3 towards = dir_ecef * distance_m - ecef_from_geodetic(observer);
  const dvec3 enu = glm::transpose(make_ecef_from_enu_rotation(observer)) * towards;
  return {std::atan2(enu.z, std::hypot(enu.x, enu.y)), positive_angle(std::atan2(enu.x, enu.y)), glm::length(enu)};
}

}  // namespace nepho
