#pragma once
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "geo/frames.h"
#include "geo/planet_view.h"
#include "gpu/frame_info.h"
#include "io/array_raster.h"
#include "terrain/tile_volume.h"

namespace nepho::test {

/// An elevation raster whose pixels are f(lat, lon) at their centres, degrees.
inline std::shared_ptr<ArrayRaster> raster_of(uint32_t width, uint32_t height, LonLatBounds bounds,
                                              const std::function<double(double, double)>& f,
                                              VerticalDatum vertical = VerticalDatum::egm96) {
  RasterInfo info;
  info.path = "test";
  info.width = width;
  info.height = height;
  info.bounds = bounds;
  info.wraps = bounds.east_deg - bounds.west_deg == 360.0;
  info.vertical = vertical;
  std::vector<float> values;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      values.push_back(
          static_cast<float>(f(bounds.north_deg - (bounds.north_deg - bounds.south_deg) * (y + 0.5) / height,
                               bounds.west_deg + (bounds.east_deg - bounds.west_deg) * (x + 0.5) / width)));
  return std::make_shared<ArrayRaster>(info, std::move(values));
}

/// Rough mountains everywhere, 0..4000 m, different at every pixel.
inline std::shared_ptr<ArrayRaster> rough_world(uint32_t width = 720) {
  uint32_t state = 12345;
  return raster_of(width, width / 2, {}, [state](double, double) mutable {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / 16777216.0 * 4000.0;
  });
}

/// Constants of a picture as the renderer makes them.
inline FrameInfo frame_at(const Geodetic& at, const Attitude& attitude, double fov_deg, Extent2D extent,
                          glm::vec2 jitter = glm::vec2(0.0f)) {
  FrameInfo frame;
  frame.extent = extent;
  frame.camera_ecef_m = ecef_from_geodetic(at);
  const CameraAxes axes = camera_axes_ecef(at, attitude);
  const double tan_y = std::tan(rad_from_deg(fov_deg) / 2), tan_x = tan_y * extent.width / extent.height;
  shared::FrameConstants& c = frame.constants;
  c = {};
  c.planet = make_planet_view(frame.camera_ecef_m);
  c.forward = vec3(axes.forward);
  c.right = vec3(axes.right * tan_x);
  c.up = vec3(axes.up * tan_y);
  c.pixel_angle_rad = static_cast<float>(2.0 * tan_y / extent.height);
  c.size = {extent.width, extent.height};
  c.jitter_px = jitter;
  c.near_m = 0.1f;
  return frame;
}

inline TerrainView view_at(const Geodetic& at, const Attitude& attitude, double fov_deg, Extent2D extent) {
  const FrameInfo frame = frame_at(at, attitude, fov_deg, extent);
  TerrainView view;
  view.camera_ecef_m = frame.camera_ecef_m;
  view.forward = glm::normalize(dvec3(frame.constants.forward));
  view.right = dvec3(frame.constants.right);
  view.up = dvec3(frame.constants.up);
  view.pixel_angle_rad = static_cast<double>(frame.constants.pixel_angle_rad);
  return view;
}

/// Unit direction of a pixel's ray in double, from the same floats as the shaders'.
inline dvec3 pixel_ray(const FrameInfo& frame, double px, double py) {
  const shared::FrameConstants& c = frame.constants;
  const double x = 2.0 * (px + static_cast<double>(c.jitter_px.x)) / frame.extent.width - 1.0;
  const double y = 1.0 - 2.0 * (py + static_cast<double>(c.jitter_px.y)) / frame.extent.height;
  return glm::normalize(dvec3(c.forward) + x * dvec3(c.right) + y * dvec3(c.up));
}

/// Distance to the ellipsoid raised by `height_m` along its axes; negative when the ray misses.
inline double hit_ellipsoid(const dvec3& origin, const dvec3& dir, double height_m = 0.0) {
  const Ellipsoid e;
  const dvec3 s(1.0 / (e.a_m + height_m), 1.0 / (e.a_m + height_m), 1.0 / (e.b_m + height_m));
  const dvec3 o = origin * s, d = dir * s;
  const double a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1.0, q = b * b - a * c;
  if (q < 0.0 || (b > 0.0 && c > 0.0)) return -1.0;
  return c > 0.0 ? c / (-b + std::sqrt(q)) : (-b + std::sqrt(q)) / a;
}

}  // namespace nepho::test
