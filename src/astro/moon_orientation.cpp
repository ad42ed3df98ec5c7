#include "astro/moon_orientation.h"

#include <erfa.h>

#include <cmath>
#include <numbers>

namespace nepho {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTilt_rad = 1.54242 * kDegree;  // IAU, as in Meeus

/// Coordinates in axes turned by `angle` about z, or about x.
dmat3 about_z(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return dmat3(dvec3(c, -s, 0.0), dvec3(s, c, 0.0), dvec3(0.0, 0.0, 1.0));
}
dmat3 about_x(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return dmat3(dvec3(1.0, 0.0, 0.0), dvec3(0.0, c, -s), dvec3(0.0, s, c));
}

}  // namespace

PhysicalLibration moon_physical_libration(double t) {
  const double d = eraFad03(t), m = eraFalp03(t), mm = eraFal03(t), f = eraFaf03(t), node = eraFaom03(t);
  const double k1 = (119.75 + 131.849 * t) * kDegree, k2 = (72.56 + 20.186 * t) * kDegree;
  const double e = 1.0 - 0.002516 * t - 0.0000074 * t * t;  // the earth's orbit becomes rounder
  const auto sin = [](double x) { return std::sin(x); };
  const auto cos = [](double x) { return std::cos(x); };
  const double rho = -0.02752 * cos(mm) - 0.02245 * sin(f) + 0.00684 * cos(mm - 2 * f) - 0.00293 * cos(2 * f) -
                     0.00085 * cos(2 * f - 2 * d) - 0.00054 * cos(mm - 2 * d) - 0.00020 * sin(mm + f) -
                     0.00020 * cos(mm + 2 * f) - 0.00020 * cos(mm - f) + 0.00014 * cos(mm + 2 * f - 2 * d);
  const double sigma = -0.02816 * sin(mm) + 0.02244 * cos(f) - 0.00682 * sin(mm - 2 * f) - 0.00279 * sin(2 * f) -
                       0.00083 * sin(2 * f - 2 * d) + 0.00069 * sin(mm - 2 * d) + 0.00040 * cos(mm + f) -
                       0.00025 * sin(2 * mm) - 0.00023 * sin(mm + 2 * f) + 0.00020 * cos(mm - f) +
                       0.00019 * sin(mm - f) + 0.00013 * sin(mm + 2 * f - 2 * d) - 0.00010 * cos(mm - 3 * f);
  const double tau = 0.02520 * e * sin(m) + 0.00473 * sin(2 * mm - 2 * f) - 0.00467 * sin(mm) + 0.00396 * sin(k1) +
                     0.00276 * sin(2 * mm - 2 * d) + 0.00196 * sin(node) - 0.00183 * cos(mm - f) +
                     0.00115 * sin(mm - 2 * d) - 0.00096 * sin(mm - d) + 0.00046 * sin(2 * f - 2 * d) -
                     0.00039 * sin(mm - f) - 0.00032 * sin(mm - m - d) + 0.00027 * sin(2 * mm - m - 2 * d) +
                     0.00023 * sin(k2) - 0.00014 * sin(2 * d) + 0.00014 * cos(2 * mm - 2 * f) -
                     0.00012 * sin(mm - 2 * f) - 0.00012 * sin(2 * mm) + 0.00011 * sin(2 * mm - 2 * m - 2 * d);
  return {rho * kDegree, sigma * kDegree, tau * kDegree};
}

dmat3 moon_body_from_mean_ecliptic(double t, const PhysicalLibration& libration) {
  const double node_shift = libration.node / std::sin(kTilt_rad);
  // Cassini: the equator's descending node on the ecliptic is the orbit's ascending one, hence the half turn, and the
  // tilt's sign; the moon turns as its mean longitude, F + node, does.
  const double turn = eraFaf03(t) + std::numbers::pi + libration.longitude - node_shift;
  return about_z(turn) * about_x(-(kTilt_rad + libration.inclination)) * about_z(eraFaom03(t) + node_shift);
}

}  // namespace nepho
