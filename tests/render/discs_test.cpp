// The part of a picture that the pass of discs draws: does it hold the whole disc, wherever that is?
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "render/background_pass.h"
#include "render/frame_setup.h"
#include "render/night_sky_shared.h"

using namespace nepho;

namespace {

shared::FrameConstants frame_of(double fov_deg, Extent2D size) {
  CameraPose pose;
  pose.at = Geodetic::from_degrees(20.0, 30.0, 100.0);
  pose.ecef_m = ecef_from_geodetic(pose.at);
  pose.axes.forward = glm::normalize(dvec3(0.3, -0.8, 0.4));
  pose.axes.right = glm::normalize(glm::cross(pose.axes.forward, dvec3(0, 0, 1)));
  pose.axes.up = glm::cross(pose.axes.right, pose.axes.forward);
  pose.fov_rad = rad_from_deg(fov_deg);
  return make_frame_constants(pose, size, FrameLight{}, 0.0, 0, 0, glm::vec2(0.0f));
}

/// What the shaders of either disc draw at most: the disc, no smaller than half a pixel, and half a pixel of edge.
float reach(const shared::FrameConstants& f, float radius) {
  return std::max(radius, 0.5f * f.pixel_angle_rad) + 0.5f * f.pixel_angle_rad;
}
float angle_between(const glm::vec3& a, const glm::vec3& b) {
  return 2.0f * std::asin(std::min(0.5f * length(a - b), 1.0f));
}

}  // namespace

TEST_CASE("the pixels of a disc hold all of it: fields of view of 1 to 150 degrees, edges, corners and behind") {
  constexpr float kSun = 0.00465f;
  for (const Extent2D size : {Extent2D{96, 64}, Extent2D{33, 17}, Extent2D{1, 1}, Extent2D{20, 90}})
    for (const double fov_deg : {1.0, 10.0, 45.0, 90.0, 150.0}) {
      const shared::FrameConstants f = frame_of(fov_deg, size);
      size_t drawn_outside = 0, drawn = 0, too_large = 0;
      for (const float radius : {kSun, 0.03f})
        for (const float x : {-1.5f, -1.03f, -1.0f, -0.6f, 0.0f, 0.013f, 0.97f, 1.0f, 1.04f, 2.0f})
          for (const float y : {-1.4f, -1.0f, -0.98f, 0.0f, 0.5f, 1.0f, 1.02f, 3.0f})
            for (const float sign : {1.0f, -1.0f}) {
              const glm::vec3 dir = normalize(sign * f.forward + x * f.right + y * f.up);
              const auto area = pixels_of_disc(f, dir, radius);
              int most_x = -1, least_x = 1 << 20, most_y = -1, least_y = 1 << 20;
              for (uint32_t py = 0; py < size.height; ++py)
                for (uint32_t px = 0; px < size.width; ++px) {
                  const glm::ivec2 p(static_cast<int>(px), static_cast<int>(py));
                  if (angle_between(shared::pixel_direction(f, glm::vec2(p) + 0.5f), dir) >= reach(f, radius)) continue;
                  ++drawn;
                  most_x = std::max(most_x, p.x), least_x = std::min(least_x, p.x);
                  most_y = std::max(most_y, p.y), least_y = std::min(least_y, p.y);
                  const bool inside =
                      area && p.x >= area->first.x && p.y >= area->first.y && p.x < area->last.x && p.y < area->last.y;
                  drawn_outside += static_cast<size_t>(!inside);
                }
              if (area) {
                CHECK(area->first.x >= 0);
                CHECK(area->first.y >= 0);
                CHECK(area->last.x <= static_cast<int>(size.width));
                CHECK(area->last.y <= static_cast<int>(size.height));
              }
              // Not much more than it needs, where perspective is moderate and the disc smaller than the picture.
              if (area && most_x >= 0 && fov_deg >= 10.0 && fov_deg <= 45.0 && size.width > 30) {
                const glm::vec2 needed(glm::ivec2(most_x - least_x, most_y - least_y)), got(area->last - area->first);
                too_large += static_cast<size_t>(got.x > 1.4f * needed.x + 14.0f || got.y > 1.4f * needed.y + 14.0f);
              }
            }
      CAPTURE(fov_deg);
      CAPTURE(size.width);
      CHECK(drawn > 0);
      CHECK(drawn_outside == 0);
      CHECK(too_large == 0);
    }
}

TEST_CASE("the moon's own cover ends within its pixels, at every field of view") {
  for (const double fov_deg : {1.0, 45.0, 150.0})
    for (const float x : {0.0f, 0.8f, 1.0f}) {
      shared::FrameConstants f = frame_of(fov_deg, {96, 64});
      f.moon_dir = normalize(f.forward + x * f.right - 0.3f * f.up);
      f.moon_angular_radius_rad = 0.0047f;
      const auto area = pixels_of_disc(f, f.moon_dir, f.moon_angular_radius_rad);
      REQUIRE(area.has_value());
      size_t outside = 0, covered = 0;
      for (int py = 0; py < 64; ++py)
        for (int px = 0; px < 96; ++px) {
          if (shared::moon_disc_cover(f, shared::pixel_direction(f, glm::vec2(px, py) + 0.5f)) <= 0.0f) continue;
          ++covered;
          outside +=
              static_cast<size_t>(px < area->first.x || py < area->first.y || px >= area->last.x || py >= area->last.y);
        }
      CAPTURE(fov_deg);
      CHECK(covered > 0);
      CHECK(outside == 0);
    }
}

TEST_CASE("a disc far outside the picture, or behind the camera, costs no pixels") {
  const shared::FrameConstants f = frame_of(45.0, {96, 64});
  CHECK_FALSE(pixels_of_disc(f, -normalize(f.forward), 0.005f).has_value());
  CHECK_FALSE(pixels_of_disc(f, normalize(f.forward + 3.0f * f.right), 0.005f).has_value());
  CHECK_FALSE(pixels_of_disc(f, normalize(f.forward - 2.0f * f.up), 0.005f).has_value());
  CHECK_FALSE(pixels_of_disc(f, normalize(-f.forward + 0.5f * f.up), 0.005f).has_value());
}
