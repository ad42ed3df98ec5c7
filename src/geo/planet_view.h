#pragma once
#include "common/planet.h"
#include "geo/geodetic.h"

namespace nepho {

/// What shaders need to know of the planet and the camera, computed in double (shaders/common/planet.h).
shared::PlanetView make_planet_view(const dvec3& camera_ecef_m, const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

}  // namespace nepho
