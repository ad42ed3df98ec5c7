#include "render/frame_setup.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "astro/moonlight.h"
#include "geo/planet_view.h"

namespace nepho {

namespace {
constexpr double kMoonLightsBelow_rad = rad_from_deg(-1.0), kMoonIsKeyBelow_rad = rad_from_deg(-9.0);
/// Moonlight comes in, and takes over as the key light, while the sun sinks by this: sunk light changes by several
/// stops meanwhile, so that neither is seen to begin.
constexpr double kHandOver_rad = rad_from_deg(4.0);
/// From space: the sunlit part of what is seen is small then, and a picture may be exposed for the rest.
constexpr double kMoonLightsFromSpaceBelow_rad = rad_from_deg(-6.0);
constexpr double kEarthRadius_m = 6371e3;
constexpr float kNear_m = 0.1f;  // reversed-Z float depth keeps its relative precision whatever this is

float halton(uint32_t index, uint32_t base) {
  float f = 1.0f, r = 0.0f;
  for (; index > 0; index /= base) {
    f /= static_cast<float>(base);
    r += f * static_cast<float>(index % base);
  }
  return r;
}

/// 0 above an elevation of the sun, 1 kHandOver_rad below it, smooth between.
double moon_ramp(double sun_elevation_rad, double begins_rad) {
  const double u = std::clamp((begins_rad - sun_elevation_rad) / kHandOver_rad, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

/// Which lights there are, and which of them casts shadows. Sun and camera are filled in already.
void set_lights(shared::FrameConstants& c, const CameraPose& pose, const FrameLight& light) {
  const dvec3 to_moon = light.moon_ecef_m - pose.ecef_m;
  const double distance_m = glm::length(to_moon);
  const dvec3 moon_dir = to_moon / distance_m;
  c.moon_dir = vec3(moon_dir);
  c.moon_angular_radius_rad = static_cast<float>(std::asin(std::min(kMoonRadius_m / distance_m, 1.0)));
  c.light_count = 1;
  c.key_dir = c.sun_dir;
  c.key_illuminance = c.sun_illuminance;
  if (!light.has_moon) return;
  const double phase = std::acos(std::clamp(glm::dot(light.sun_from_moon_ecef, -moon_dir), -1.0, 1.0));
  c.moon_share = vec3(moon_sun_illuminance_ratio(phase, distance_m, light.sun_moon_distance_au) * moonlight_color());
  const double sun_elevation = std::asin(
      std::clamp(glm::dot(geodetic_up_ecef(pose.at.lat_rad, pose.at.lon_rad), light.sun_dir_ecef), -1.0, 1.0));
  const double dip = std::acos(kEarthRadius_m / (kEarthRadius_m + std::max(pose.at.height_m, 0.0)));
  const double lights_below =
      pose.at.height_m > kNightSkyAbove_m ? kMoonLightsFromSpaceBelow_rad : kMoonLightsBelow_rad;
  if (sun_elevation < lights_below) {
    c.light_count = 2;
    c.moon_share *= static_cast<float>(moon_ramp(sun_elevation, lights_below));
  }
  const double key_below = kMoonIsKeyBelow_rad - dip;
  if (sun_elevation < key_below) {
    c.key_dir = c.moon_dir;
    c.key_illuminance = static_cast<float>(moon_ramp(sun_elevation, key_below)) * c.moon_share * c.sun_illuminance_1au;
  }
}
}  // namespace

FrameLight FrameLight::from(const SkyBodies& sky, const vec3& sun_illuminance_at_1au, bool has_moon) {
  return {.sun_dir_ecef = sky.sun.dir_ecef,
          .sun_angular_radius_rad = sky.sun.angular_radius_rad,
          .sun_distance_au = sky.sun.distance_au,
          .sun_illuminance_at_1au = sun_illuminance_at_1au,
          .has_moon = has_moon,
          .moon_ecef_m = sky.moon.dir_ecef * sky.moon.distance_m,
          .sun_from_moon_ecef = sky.moon.sun_from_moon_ecef,
          .sun_moon_distance_au = sky.moon.sun_distance_au};
}

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
  // From the camera: 9 arc seconds of parallax, which decide where an eclipse is total.
  c.sun_dir = vec3(glm::normalize(light.sun_dir_ecef * (light.sun_distance_au * kAstronomicalUnit_m) - pose.ecef_m));
  c.sun_angular_radius_rad = static_cast<float>(light.sun_angular_radius_rad);
  c.sun_distance_factor = static_cast<float>(1.0 / (light.sun_distance_au * light.sun_distance_au));
  c.sun_illuminance = light.sun_illuminance_at_1au * c.sun_distance_factor;
  c.sun_illuminance_1au = light.sun_illuminance_at_1au;
  set_lights(c, pose, light);
  c.size = glm::uvec2(extent.width, extent.height);
  c.jitter_px = jitter_px;
  c.near_m = kNear_m;
  return c;
}

}  // namespace nepho
