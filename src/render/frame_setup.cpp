#include "render/frame_setup.h"

#include <cmath>

#include "geo/planet_view.h"

namespace nepho {

namespace {
constexpr float kNear_m = 0.1f;  // reversed-Z float depth keeps its relative precision whatever this is

float halton(uint32_t index, uint32_t base) {
  float f = 1.0f, r = 0.0f;
  for (; index > 0; index /= base) {
    f /= static_cast<float>(base);
    r += f * static_cast<float>(index % base);
  }
  return r;
}
}  // namespace

glm::vec2 frame_jitter(uint32_t frame_index) {
  if (frame_index == 0) return glm::vec2(0.0f);
  return glm::vec2(halton(frame_index, 2) - 0.5f, halton(frame_index, 3) - 0.5f);
}

shared::FrameConstants make_frame_constants(const CameraPose& pose, Extent2D extent, const FrameLight& light,
                                            double time_s, uint32_t frame_index, uint32_t seed, glm::vec2 jitter_px) {
  const double tan_y = std::tan(0.5 * pose.fov_rad);
  const double tan_x = tan_y * extent.width / extent.height;
  shared::FrameConstants c{};
  c.planet = make_planet_view(pose.ecef_m);
  c.forward = vec3(pose.axes.forward);
  c.right = vec3(pose.axes.right * tan_x);
  c.up = vec3(pose.axes.up * tan_y);
  c.pixel_angle_rad = static_cast<float>(2.0 * tan_y / extent.height);
  c.time_s = static_cast<float>(time_s);
  c.frame_index = frame_index;
  c.seed = seed;
  c.camera_up = vec3(geodetic_up_ecef(pose.at.lat_rad, pose.at.lon_rad));
  c.sun_dir = vec3(light.sun_dir_ecef);
  c.sun_angular_radius_rad = static_cast<float>(light.sun_angular_radius_rad);
  c.sun_distance_factor = static_cast<float>(1.0 / (light.sun_distance_au * light.sun_distance_au));
  c.sun_illuminance = light.sun_illuminance_at_1au * c.sun_distance_factor;
  c.size = glm::uvec2(extent.width, extent.height);
  c.jitter_px = jitter_px;
  c.near_m = kNear_m;
  return c;
}

}  // namespace nepho
