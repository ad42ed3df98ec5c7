#include "geo/frames.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace nepho {

dmat3 make_ecef_from_enu_rotation(const Geodetic& origin) {
  const double sin_lat = std::sin(origin.lat_rad), cos_lat = std::cos(origin.lat_rad);
  const double sin_lon = std::sin(origin.lon_rad), cos_lon = std::cos(origin.lon_rad);
  return dmat3(dvec3(-sin_lon, cos_lon, 0.0), dvec3(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
               dvec3(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat));
}

dmat4 make_ecef_from_enu(const Geodetic& origin, const Ellipsoid& ellipsoid) {
  dmat4 m(make_ecef_from_enu_rotation(origin));
  m[3] = glm::dvec4(ecef_from_geodetic(origin, ellipsoid), 1.0);
  return m;
}

dmat4 make_enu_from_ecef(const Geodetic& origin, const Ellipsoid& ellipsoid) {
  const dmat3 enu_from_ecef = glm::transpose(make_ecef_from_enu_rotation(origin));
  dmat4 m(enu_from_ecef);
  m[3] = glm::dvec4(-(enu_from_ecef * ecef_from_geodetic(origin, ellipsoid)), 1.0);
  return m;
}

Attitude Attitude::from_degrees(double heading_deg, double pitch_deg, double roll_deg) {
  return {rad_from_deg(heading_deg), rad_from_deg(pitch_deg), rad_from_deg(roll_deg)};
}

CameraAxes camera_axes_ecef(const Geodetic& camera, const Attitude& attitude) {
  const double sin_h = std::sin(attitude.heading_rad), cos_h = std::cos(attitude.heading_rad);
  const double sin_p = std::sin(attitude.pitch_rad), cos_p = std::cos(attitude.pitch_rad);
  const double sin_r = std::sin(attitude.roll_rad), cos_r = std::cos(attitude.roll_rad);
  const dvec3 forward(cos_p * sin_h, cos_p * cos_h, sin_p);
  const dvec3 level_right(cos_h, -sin_h, 0.0);
  const dvec3 level_up(-sin_p * sin_h, -sin_p * cos_h, cos_p);
  const dmat3 ecef_from_enu = make_ecef_from_enu_rotation(camera);
  return {ecef_from_enu * forward, ecef_from_enu * (cos_r * level_right - sin_r * level_up),
          ecef_from_enu * (cos_r * level_up + sin_r * level_right)};
}

std::optional<Attitude> heading_pitch_towards(const Geodetic& camera, const Geodetic& target,
                                              const Ellipsoid& ellipsoid) {
  // The difference first: the translation of make_enu_from_ecef would cost the last digits of a short distance.
  const dvec3 offset_ecef = ecef_from_geodetic(target, ellipsoid) - ecef_from_geodetic(camera, ellipsoid);
  const double distance_m = glm::length(offset_ecef);
  if (!(distance_m > 1e-6)) return std::nullopt;
  const dvec3 enu = glm::transpose(make_ecef_from_enu_rotation(camera)) * offset_ecef;
  const double horizontal_m = std::hypot(enu.x, enu.y);
  Attitude attitude;
  attitude.pitch_rad = std::atan2(enu.z, horizontal_m);
  // 1e-8 m is the precision of the two positions: below it the heading is noise.
  if (horizontal_m > 1e-8) attitude.heading_rad = std::atan2(enu.x, enu.y);
  return attitude;
}

}  // namespace nepho
