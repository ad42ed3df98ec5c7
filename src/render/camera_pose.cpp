#include "render/camera_pose.h"

#include "base/error.h"

namespace nepho {

namespace {
constexpr double kEyeHeight_m = 2.0;
}

CameraPose resolve_camera(const CameraParams& params, const GroundHeight& ground) {
  CameraPose pose;
  pose.at = Geodetic::from_degrees(params.lat_deg, params.lon_deg);
  pose.at.height_m = params.height_m ? *params.height_m
                                     : ground(pose.at.lat_rad, pose.at.lon_rad) + params.agl_m.value_or(kEyeHeight_m);
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

}  // namespace nepho
