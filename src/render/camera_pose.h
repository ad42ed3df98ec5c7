#pragma once
#include <functional>

#include "geo/frames.h"
#include "geo/geodetic.h"
#include "scene/scene.h"

namespace nepho {

/// Height of the drawn surface above the ellipsoid, m, at a latitude and longitude in radians.
using GroundHeight = std::function<double(double lat_rad, double lon_rad)>;

/// A camera placed and aimed.
struct CameraPose {
  Geodetic at;
  Attitude attitude;
  dvec3 ecef_m{0.0};
  CameraAxes axes;       ///< unit vectors, ECEF
  double fov_rad = 0.0;  ///< vertical
};

/// Heights above the ground and look-at points without a height are settled with `ground`. With neither height_m nor
/// agl_m the camera stands 2 m above the ground. Throws Error(usage) when the target is where the camera is.
CameraPose resolve_camera(const CameraParams& params, const GroundHeight& ground);

}  // namespace nepho
