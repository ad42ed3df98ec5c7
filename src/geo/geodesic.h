#pragma once
#include "geo/geodetic.h"

namespace nepho {

/// Shortest path between two places on WGS84 (heights play no part). Azimuths are clockwise from north, in (-pi, pi].
struct GeodesicInverse {
  double distance_m = 0.0;    ///< along the ellipsoid
  double azimuth1_rad = 0.0;  ///< at the first point, towards the second
  double azimuth2_rad = 0.0;  ///< at the second point, onwards
  double arc_rad = 0.0;       ///< on the auxiliary sphere
};

/// Karney's algorithm (GeographicLib): within 15 nm, nearly antipodal points included. Coincident points: azimuths 0 or
/// pi.
GeodesicInverse geodesic_inverse(const Geodetic& from, const Geodetic& to);

struct GeodesicEnd {
  Geodetic point;            ///< height as `from`'s
  double azimuth_rad = 0.0;  ///< direction of travel there
};

/// The place reached after `distance_m` (negative: backwards) from `from` in direction `azimuth_rad`.
GeodesicEnd geodesic_direct(const Geodetic& from, double azimuth_rad, double distance_m);

/// A shortest path walked by fraction.
class GeodesicPath {
 public:
  GeodesicPath(const Geodetic& from, const Geodetic& to);
  double distance_m() const { return inverse_.distance_m; }
  /// 0 is `from`, 0.25 a quarter of the way by distance, 1 is `to`; outside 0..1 the path goes on. The height runs
  /// linearly from one end's to the other's.
  Geodetic at(double fraction) const;

 private:
  Geodetic from_;
  double to_height_m_;
  GeodesicInverse inverse_;
};

}  // namespace nepho
