#include "geo/geodetic.h"

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace nepho {

namespace {
GeographicLib::Geocentric geocentric(const Ellipsoid& ellipsoid) {
  // The flattening of WGS84 is defined, its b is derived: the defined number costs nothing and is exact.
  if (ellipsoid == Ellipsoid::wgs84()) return GeographicLib::Geocentric::WGS84();
  return {ellipsoid.a_m, ellipsoid.flattening()};
}
}  // namespace

Geodetic Geodetic::from_degrees(double lat_deg, double lon_deg, double height_m) {
  double lon = std::remainder(lon_deg, 360.0);  // exact, in [-180, 180]
  if (lon == -180.0) lon = 180.0;
  return {rad_from_deg(lat_deg), rad_from_deg(lon), height_m};
}

dvec3 ecef_from_geodetic(const Geodetic& at, const Ellipsoid& ellipsoid) {
  dvec3 p;
  // Radians to degrees may round past the pole, for which GeographicLib answers NaN.
  const double lat_deg = std::clamp(at.lat_deg(), -90.0, 90.0);
  geocentric(ellipsoid).Forward(lat_deg, at.lon_deg(), at.height_m, p.x, p.y, p.z);
  return p;
}

Geodetic geodetic_from_ecef(const dvec3& ecef_m, const Ellipsoid& ellipsoid) {
  double lat_deg = 0.0, lon_deg = 0.0, height_m = 0.0;
  geocentric(ellipsoid).Reverse(ecef_m.x, ecef_m.y, ecef_m.z, lat_deg, lon_deg, height_m);
  return Geodetic::from_degrees(lat_deg, lon_deg, height_m);
}

dvec3 geodetic_up_ecef(double lat_rad, double lon_rad) {
  const double c = std::cos(lat_rad);
  return {c * std::cos(lon_rad), c * std::sin(lon_rad), std::sin(lat_rad)};
}

dvec3 map_direction_from_ecef(const dvec3& ecef_m, const Ellipsoid& ellipsoid) {
  return glm::normalize(dvec3(ecef_m.x, ecef_m.y, ecef_m.z * ellipsoid.a_over_b()));
}

}  // namespace nepho
