#pragma once
#include <functional>
#include <optional>

#include "geo/frames.h"
#include "geo/geodetic.h"
#include "scene/scene.h"
#include "terrain/height_sampler.h"

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
  /// Where it was asked to be, m above the ellipsoid, when that was in the ground and it was lifted out.
  std::optional<double> lifted_from_m;
};

/// Heights above the ground and look-at points without a height are settled with `ground`. With neither height_m nor
/// agl_m the camera stands 2 m above the ground. A camera that is under the ground or less than 0.1 m above it, where
/// the near plane would cut the ground open, is lifted to 2 m above it and aimed from there, unless
/// params.allow_underground. `highest_ground_m`: no ground is higher; cameras above it are not asked about. Throws
/// Error(usage) when the target is where the camera is.
CameraPose resolve_camera(const CameraParams& params, const GroundHeight& ground, double highest_ground_m = 1e30);

/// The same on the ground that is drawn (terrain/surface_query.h).
CameraPose resolve_camera(const CameraParams& params, const HeightSampler& ground);

/// One warning with both heights, if the camera was lifted. Of a sequence call it for the first such picture alone.
void warn_if_lifted(const CameraPose& pose);

}  // namespace nepho
