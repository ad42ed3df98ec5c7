#pragma once
#include "gpu/frame_info.h"
#include "render/camera_pose.h"

namespace nepho {

/// The light and clock of one frame.
struct FrameLight {
  dvec3 sun_dir_ecef{1.0, 0.0, 0.0};         ///< unit, towards the sun
  double sun_angular_radius_rad = 0.004652;  ///< seen from the Earth's centre
  double sun_distance_au = 1.0;
  vec3 sun_illuminance_at_1au{0.0f};  ///< lux, linear Rec. 709 (atmosphere/luminance.h)
};

/// Everything that shaders need of camera, planet, sun and clock, computed in double and narrowed once.
/// `jitter_px` moves this frame's rays within their pixels.
shared::FrameConstants make_frame_constants(const CameraPose& pose, Extent2D extent, const FrameLight& light,
                                            double time_s, uint32_t frame_index, uint32_t seed, glm::vec2 jitter_px);

/// Sub-pixel offset of frame i, -0.5..0.5: frame 0 is the pixel centre, the others a Halton (2, 3) sequence.
glm::vec2 frame_jitter(uint32_t frame_index);

}  // namespace nepho
