#pragma once
#include "common/region_map.h"
#include "geo/geodetic.h"

namespace nepho {

/// Nested square maps about the place below `centre_ecef_m` in scaled space (shaders/common/region_map.h). East and
/// north follow the meridian; on the axis east is that of longitude 0. The centre of the Earth has no place below.
/// `half_m`: half the side of level 0, > 0.
shared::RegionMap make_region_map(const dvec3& centre_ecef_m, double half_m, uint32_t levels,
                                  const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// The place of the ellipsoid whose map_direction_from_ecef() this is (a unit vector).
Geodetic geodetic_from_map_direction(const dvec3& direction, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

}  // namespace nepho
