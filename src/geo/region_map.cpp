#include "geo/region_map.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"

namespace nepho {

static_assert(sizeof(shared::RegionMap) == 48);

shared::RegionMap make_region_map(const dvec3& centre_ecef_m, double half_m, uint32_t levels,
                                  const Ellipsoid& ellipsoid) {
  NEPHO_ASSERT(half_m > 0.0 && levels > 0);
  const dvec3 centre = map_direction_from_ecef(centre_ecef_m, ellipsoid);
  const double across = std::hypot(centre.x, centre.y);
  const dvec3 east = across > 0.0 ? dvec3(-centre.y / across, centre.x / across, 0.0) : dvec3(0.0, 1.0, 0.0);
  shared::RegionMap map;
  map.centre = vec3(centre);
  map.east = vec3(east);
  map.north = vec3(glm::cross(centre, east));
  map.half_m = static_cast<float>(half_m);
  map.radius_m = static_cast<float>(ellipsoid.a_m);
  map.levels = levels;
  return map;
}

Geodetic geodetic_from_map_direction(const dvec3& direction, const Ellipsoid& ellipsoid) {
  // The normal of the ellipsoid is S q: that of the sphere, stretched once more along the axis.
  return {std::atan2(direction.z * ellipsoid.a_over_b(), std::hypot(direction.x, direction.y)),
          std::atan2(direction.y, direction.x), 0.0};
}

}  // namespace nepho
