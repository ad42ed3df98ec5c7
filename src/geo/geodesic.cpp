#include "geo/geodesic.h"

#include <GeographicLib/Geodesic.hpp>

namespace nepho {

GeodesicInverse geodesic_inverse(const Geodetic& from, const Geodetic& to) {
  double s12 = 0.0, azi1 = 0.0, azi2 = 0.0;
  const double a12 = GeographicLib::Geodesic::WGS84().Inverse(from.lat_deg(), from.lon_deg(), to.lat_deg(),
                                                              to.lon_deg(), s12, azi1, azi2);
  return {s12, rad_from_deg(azi1), rad_from_deg(azi2), rad_from_deg(a12)};
}

GeodesicEnd geodesic_direct(const Geodetic& from, double azimuth_rad, double distance_m) {
  double lat = 0.0, lon = 0.0, azi2 = 0.0;
  GeographicLib::Geodesic::WGS84().Direct(from.lat_deg(), from.lon_deg(), deg_from_rad(azimuth_rad), distance_m, lat,
                                          lon, azi2);
  return {Geodetic::from_degrees(lat, lon, from.height_m), rad_from_deg(azi2)};
}

GeodesicPath::GeodesicPath(const Geodetic& from, const Geodetic& to)
    : from_(from), to_height_m_(to.height_m), inverse_(geodesic_inverse(from, to)) {}

Geodetic GeodesicPath::at(double fraction) const {
  Geodetic point = geodesic_direct(from_, inverse_.azimuth1_rad, fraction * inverse_.distance_m).point;
  point.height_m = from_.height_m + fraction * (to_height_m_ - from_.height_m);
  return point;
}

}  // namespace nepho
