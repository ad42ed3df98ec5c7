#include "render/camera_pose.h"

#include "base/error.h"
#include "base/log.h"
#include "terrain/surface_query.h"

namespace nepho {

namespace {
constexpr double kEyeHeight_m = 2.0;
/// The near plane's distance (frame_setup.cpp): nearer to the ground than this a camera looks through it.
constexpr double kClearance_m = 0.1;
}  // namespace

CameraPose resolve_camera(const CameraParams& params, const GroundHeight& ground, double highest_ground_m) {
  CameraPose pose;
  pose.at = Geodetic::from_degrees(params.lat_deg, params.lon_deg);
  pose.at.height_m = params.height_m.value_or(0.0);
  const bool may_be_under = !params.allow_underground && pose.at.height_m < highest_ground_m + kClearance_m;
  if (!params.height_m || may_be_under) {
    const double ground_m = ground(pose.at.lat_rad, pose.at.lon_rad);
    if (!params.height_m) pose.at.height_m = ground_m + params.agl_m.value_or(kEyeHeight_m);
    // A hair less: heights that were added up must not count as too low by their rounding.
    if (!params.allow_underground && pose.at.height_m < ground_m + kClearance_m - 1e-6) {
      pose.lifted_from_m = pose.at.height_m;
      pose.at.height_m = ground_m + kEyeHeight_m;
    }
  }
  pose.attitude = Attitude::from_degrees(params.heading_deg, params.pitch_deg, params.roll_deg);
  if (params.look_at) {
    Geodetic target = Geodetic::from_degrees(params.look_at->lat_deg, params.look_at->lon_deg);
    target.height_m = params.look_at->height_m ? *params.look_at->height_m : ground(target.lat_rad, target.lon_rad);
    const std::optional<Attitude> towards = heading_pitch_towards(pose.at, target);
    if (!towards)
      throw Error(ErrorKind::usage, "look_at: the point to look at is where the camera stands; move one of them");
    pose.attitude.heading_rad = towards->heading_rad;
    pose.attitude.pitch_rad = towards->pitch_rad;
  }
  pose.ecef_m = ecef_from_geodetic(pose.at);
  pose.axes = camera_axes_ecef(pose.at, pose.attitude);
  pose.fov_rad = rad_from_deg(params.fov_deg);
  return pose;
}

CameraPose resolve_camera(const CameraParams& params, const HeightSampler& ground) {
  return resolve_camera(
      params, [&](double lat_rad, double lon_rad) { return surface_height_m(ground, lat_rad, lon_rad); },
      ground.highest_land_m());
}

void warn_if_lifted(const CameraPose& pose) {
  if (!pose.lifted_from_m) return;
  log_warning(
      "camera: {:.1f} m above the ellipsoid is in the ground at {:.6f}, {:.6f}; lifted to {:.1f} m, {:.0f} m above the "
      "ground; --allow-underground keeps it",
      *pose.lifted_from_m, pose.at.lat_deg(), pose.at.lon_deg(), pose.at.height_m, kEyeHeight_m);
}

}  // namespace nepho
