#pragma once
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <numbers>

namespace nepho {

using glm::dmat3;
using glm::dmat4;
using glm::dvec3;
using glm::vec3;

/// Degrees live at the edges of the program (files, command line); radians inside.
constexpr double rad_from_deg(double deg) { return deg * (std::numbers::pi / 180.0); }
constexpr double deg_from_rad(double rad) { return rad * (180.0 / std::numbers::pi); }

/// An oblate ellipsoid of revolution about the z axis. b = a is a sphere.
struct Ellipsoid {
  double a_m = 6378137.0;          ///< equatorial radius, m. Default: WGS84
  double b_m = 6356752.314245179;  ///< polar radius, m
  static constexpr Ellipsoid wgs84() { return {}; }
  static constexpr Ellipsoid sphere(double radius_m) { return {radius_m, radius_m}; }
  constexpr double flattening() const { return (a_m - b_m) / a_m; }
  /// z in scaled space: S = diag(1, 1, a/b) makes the ellipsoid a sphere of radius a.
  constexpr double a_over_b() const { return a_m / b_m; }
  bool operator==(const Ellipsoid&) const = default;
};

/// A place on or above an ellipsoid.
struct Geodetic {
  double lat_rad = 0.0;   ///< geodetic latitude, north positive, -pi/2..pi/2
  double lon_rad = 0.0;   ///< east positive, (-pi, pi]
  double height_m = 0.0;  ///< above the ellipsoid; heights above the geoid are named `msl_m`
  /// Any longitude is brought into (-180, 180]. The latitude is taken as it is: callers check -90..90 at the edge.
  static Geodetic from_degrees(double lat_deg, double lon_deg, double height_m = 0.0);
  double lat_deg() const { return deg_from_rad(lat_rad); }
  double lon_deg() const { return deg_from_rad(lon_rad); }
  bool operator==(const Geodetic&) const = default;
};

/// Earth-fixed position (EPSG:4978), m: +X at 0N 0E, +Y at 0N 90E, +Z at the north pole. Within 1e-8 m up to 40,000 km.
dvec3 ecef_from_geodetic(const Geodetic& at, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// The inverse (Karney's closed form in GeographicLib): 1e-8 m from -11 km to 40,000 km, and exact in the sense of the
/// nearest point of the ellipsoid deep inside too. On the z axis the longitude is 0; the centre has latitude 90.
Geodetic geodetic_from_ecef(const dvec3& ecef_m, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// Unit normal of the ellipsoid, towards the sky: the same for every ellipsoid, as the latitude is geodetic.
dvec3 geodetic_up_ecef(double lat_rad, double lon_rad);

/// The direction by which weather maps and cube spheres are looked up: normalize(S p), S = diag(1, 1, a/b). It has the
/// parametric ("reduced") latitude of the place below in scaled space. Undefined at the centre of the Earth.
dvec3 map_direction_from_ecef(const dvec3& ecef_m, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

}  // namespace nepho
