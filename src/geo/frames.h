#pragma once
#include <optional>

#include "geo/geodetic.h"

namespace nepho {

/// Columns are the unit vectors east, north and up at a place, in ECEF axes. At the poles east follows the longitude.
dmat3 make_ecef_from_enu_rotation(const Geodetic& origin);

/// Local east-north-up metres to ECEF metres.
dmat4 make_ecef_from_enu(const Geodetic& origin, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// The inverse, from the transposed rotation.
dmat4 make_enu_from_ecef(const Geodetic& origin, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// Camera-relative position (ECEF axes, origin at the camera, float): subtract in double, then narrow.
inline vec3 cam_from_ecef(const dvec3& point_ecef_m, const dvec3& camera_ecef_m) {
  return vec3(point_ecef_m - camera_ecef_m);
}

/// Where a camera looks, in its local horizon.
struct Attitude {
  double heading_rad = 0.0;  ///< clockwise from north
  double pitch_rad = 0.0;    ///< 0 the horizon, -pi/2 straight down
  double roll_rad = 0.0;     ///< clockwise as seen from behind the camera
  static Attitude from_degrees(double heading_deg, double pitch_deg, double roll_deg = 0.0);
  bool operator==(const Attitude&) const = default;
};

/// Orthonormal, ECEF axes: up = cross(right, forward).
struct CameraAxes {
  dvec3 forward, right, up;
};

/// Axes of a camera in ECEF. Looking straight up or down, the heading still says where the picture's edge points.
CameraAxes camera_axes_ecef(const Geodetic& camera, const Attitude& attitude);

/// Attitude (roll 0) that puts `target` in the centre of the picture. Looking straight up or down the heading is 0.
/// Empty when the two places coincide (closer than 1 um).
std::optional<Attitude> heading_pitch_towards(const Geodetic& camera, const Geodetic& target,
                                              const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

}  // namespace nepho
