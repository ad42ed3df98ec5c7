#pragma once
#include "astro/sky_bodies.h"
#include "gpu/frame_info.h"
#include "render/camera_pose.h"

namespace nepho {

/// Cameras above this see the night sky beside the sunlit Earth, m.
inline constexpr double kNightSkyAbove_m = 60e3;

/// The light and clock of one frame.
struct FrameLight {
  dvec3 sun_dir_ecef{1.0, 0.0, 0.0};         ///< unit, towards the sun, from the Earth's centre
  double sun_angular_radius_rad = 0.004652;  ///< seen from the Earth's centre
  double sun_distance_au = 1.0;
  vec3 sun_illuminance_at_1au{0.0f};  ///< lux, linear Rec. 709 (atmosphere/luminance.h)
  bool has_moon = false;              ///< the scene has a moon; its place and light are the camera's
  dvec3 moon_ecef_m{kMeanMoonDistance_m, 0.0, 0.0};
  dvec3 sun_from_moon_ecef{1.0, 0.0, 0.0};  ///< unit, from the moon towards the sun
  double sun_moon_distance_au = 1.0;
  static constexpr double kMeanMoonDistance_m = 384400e3;
  /// Sun and moon of a moment.
  static FrameLight from(const SkyBodies& sky, const vec3& sun_illuminance_at_1au, bool has_moon);
};

/// Everything that shaders need of camera, planet, sun and clock, computed in double and narrowed once.
/// `jitter_px` moves this frame's rays within their pixels. The moon lights (light_count 2) once the sun is below -1
/// degree at the camera, from above 60 km below -6: moon_share grows from 0 to the whole while the sun sinks by 4
/// degrees more. It is the key light, the one that casts shadows, once nothing that the camera can see may be sunlit:
/// the sun lower at the camera than -9 degrees less the dip of the horizon; key_illuminance too grows from 0 while the
/// sun sinks by 4 degrees more. What of its light is not yet the key light's falls without shadows
/// (moon_fill_illuminance of atmosphere_lookup.glsl).
shared::FrameConstants make_frame_constants(const CameraPose& pose, Extent2D extent, const FrameLight& light,
                                            double time_s, uint32_t frame_index, uint32_t seed, glm::vec2 jitter_px);

/// Sub-pixel offset of frame i, -0.5..0.5: frame 0 is the pixel centre, the others a Halton (2, 3) sequence.
glm::vec2 frame_jitter(uint32_t frame_index);

}  // namespace nepho
