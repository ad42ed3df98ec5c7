#include "clouds/shadow_cascades.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "geo/geodetic.h"

namespace nepho {
namespace {

constexpr double kFadeFrom = 0.88;      // of a slice's far end
constexpr double kLastFadeFrom = 0.97;  // of the range

/// Distances at which a ray from outside or inside meets the ellipsoid raised by a scaled height; false: never.
bool meet_shell(const glm::dvec3& q, const glm::dvec3& d, double radius_m, double& from, double& to) {
  const double a = dot(d, d), b = dot(q, d), c = dot(q, q) - radius_m * radius_m;
  const double root = b * b - a * c;
  if (root < 0.0) return false;
  from = (-b - std::sqrt(root)) / a;
  to = (-b + std::sqrt(root)) / a;
  return true;
}

}  // namespace

double automatic_shadow_range_m(double camera_height_m, double top_m) {
  const double a = Ellipsoid::wgs84().a_m, h = std::max(camera_height_m, 2.0), top = std::max(top_m, 100.0);
  const double limb = std::sqrt(h * (2.0 * a + h)) + std::sqrt(top * (2.0 * a + top));
  return std::min(30e3 + 4.0 * h + h * h / 50e3, limb);
}

std::vector<ShadowSlice> shadow_slices(const CloudShadowParams& params, double nearest_m, double far_m) {
  const double share = params.split == "uniform" ? 0.0 : params.split == "logarithmic" ? 1.0 : params.split_lambda;
  const double near_m = std::clamp(nearest_m, far_m / 200.0, 0.9 * far_m);
  const double first = nearest_m > far_m / 200.0 ? near_m : 0.0;
  std::vector<ShadowSlice> slices(params.cascades);
  for (uint32_t i = 0; i < params.cascades; ++i) {
    const double u = (i + 1.0) / params.cascades;
    const double logarithmic = near_m * std::pow(far_m / near_m, u), uniform = near_m + (far_m - near_m) * u;
    slices[i].far_m = share * logarithmic + (1.0 - share) * uniform;
    slices[i].near_m = i == 0 ? first : slices[i - 1].fade_m;
    const double from = i + 1 < params.cascades ? kFadeFrom : kLastFadeFrom;
    slices[i].fade_m = std::max(from * slices[i].far_m, slices[i].near_m);
  }
  return slices;
}

SliceBall ball_of_slice(double near_m, double far_m, double half_angle_rad) {
  const double c = std::cos(half_angle_rad), s = std::sin(half_angle_rad);
  const auto radius = [&](double ahead) {
    return std::max({far_m - ahead, std::hypot(far_m * c - ahead, far_m * s), std::abs(near_m - ahead),
                     std::hypot(near_m * c - ahead, near_m * s)});
  };
  double low = 0.0, high = far_m;
  for (int i = 0; i < 100; ++i) {
    const double third = (high - low) / 3.0, nearer = low + third, further = high - third;
    if (radius(nearer) < radius(further))
      high = further;
    else
      low = nearer;
  }
  return {.ahead_m = low, .radius_m = radius(low)};
}

LightAxes LightAxes::towards(const glm::dvec3& light) {
  LightAxes axes;
  axes.light = normalize(light);
  const glm::dvec3 aside = std::abs(axes.light.z) < 0.99 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  axes.x = normalize(cross(aside, axes.light));
  axes.y = cross(axes.light, axes.x);
  return axes;
}

std::vector<uint8_t> tiles_in_view(const shared::FrameConstants& frame, const glm::dvec3& camera_ecef_m,
                                   const LightAxes& axes, const ShadowGrid& grid, double near_m, double far_m,
                                   double low_m, double high_m) {
  const uint32_t side = grid.tiles;
  std::vector<uint8_t> marks(size_t{side} * side, 0);
  const glm::dvec3 forward(frame.forward), right(frame.right), up(frame.up);
  const double a = Ellipsoid::wgs84().a_m, stretch = Ellipsoid::wgs84().a_over_b();
  const auto scaled = [&](const glm::dvec3& v) { return glm::dvec3(v.x, v.y, v.z * stretch); };
  const glm::dvec3 q = scaled(camera_ecef_m);
  const double camera_x = dot(camera_ecef_m, axes.x) - static_cast<double>(grid.first_x) * grid.tile_m;
  const double camera_y = dot(camera_ecef_m, axes.y) - static_cast<double>(grid.first_y) * grid.tile_m;
  // Rays as close to each other as tiles are at the far end, a little more than the picture's.
  constexpr double kWider = 1.04;
  const auto count = [&](const glm::dvec3& tangents) {
    return std::clamp(static_cast<int>(std::ceil(2.0 * kWider * length(tangents) * far_m / grid.tile_m)), 4, 96) + 1;
  };
  const int columns = count(right), rows = count(up);
  struct Ray {
    bool hit = false;
    double from = 0.0, to = 0.0;  // where it is in the shell
  };
  const auto mark_ray = [&](double x, double y) {
    const glm::dvec3 dir = normalize(forward + x * right + y * up);
    double outer_from = 0.0, outer_to = 0.0, inner_from = 0.0, inner_to = 0.0;
    Ray ray;
    if (!meet_shell(q, scaled(dir), a + 1.0034 * high_m + 1.0, outer_from, outer_to)) return ray;
    ray.from = std::max(near_m, outer_from);
    ray.to = std::min(far_m, outer_to);
    if (meet_shell(q, scaled(dir), a + 1.0034 * std::min(low_m, 0.0), inner_from, inner_to) && inner_from > 0.0)
      ray.to = std::min(ray.to, inner_from);
    ray.hit = ray.from < ray.to;
    if (!ray.hit) return ray;
    const double dx = dot(dir, axes.x), dy = dot(dir, axes.y);
    const double across = std::hypot(dx, dy) * (ray.to - ray.from) / grid.tile_m;
    const int steps = static_cast<int>(std::ceil(across)) + 1;
    for (int k = 0; k <= steps; ++k) {
      const double t = ray.from + (ray.to - ray.from) * k / steps;
      const auto tx = static_cast<int64_t>(std::floor((camera_x + t * dx) / grid.tile_m));
      const auto ty = static_cast<int64_t>(std::floor((camera_y + t * dy) / grid.tile_m));
      if (tx < 0 || ty < 0 || tx >= int64_t{side} || ty >= int64_t{side}) continue;
      marks[static_cast<size_t>(ty) * side + static_cast<size_t>(tx)] = 1;
    }
    return ray;
  };
  // Seen flat from far, the shell is passed in a small part of a step of y: halved until rays connect.
  const std::function<void(double, double, double, const Ray&, const Ray&, int)> between =
      [&](double x, double y0, double y1, const Ray& r0, const Ray& r1, int depth) {
        const bool apart = r0.hit && r1.hit && (r1.from > r0.to + grid.tile_m || r0.from > r1.to + grid.tile_m);
        if (depth == 0 || (r0.hit == r1.hit && !apart)) return;
        const double y = 0.5 * (y0 + y1);
        const Ray middle = mark_ray(x, y);
        between(x, y0, y, r0, middle, depth - 1);
        between(x, y, y1, middle, r1, depth - 1);
      };
  constexpr int kHalvings = 9;
  for (int i = 0; i < columns; ++i) {
    const double x = kWider * (2.0 * i / (columns - 1) - 1.0);
    Ray last;
    for (int j = 0; j < rows; ++j) {
      const double y = kWider * (2.0 * j / (rows - 1) - 1.0);
      const Ray ray = mark_ray(x, y);
      if (j > 0) between(x, y - kWider * 2.0 / (rows - 1), y, last, ray, kHalvings);
      last = ray;
    }
  }
  return widened(marks, side);
}

std::vector<uint8_t> widened(const std::vector<uint8_t>& tiles, uint32_t side) {
  std::vector<uint8_t> out(tiles.size(), 0);
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      if (!tiles[size_t{y} * side + x]) continue;
      for (uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, side - 1); ++v)
        for (uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, side - 1); ++u) out[size_t{v} * side + u] = 1;
    }
  return out;
}

std::vector<uint8_t> surrounded(const std::vector<uint8_t>& tiles, uint32_t side) {
  std::vector<uint8_t> out(tiles.size(), 0);
  for (uint32_t y = 1; y + 1 < side; ++y)
    for (uint32_t x = 1; x + 1 < side; ++x) {
      bool all = true;
      for (uint32_t v = y - 1; v <= y + 1; ++v)
        for (uint32_t u = x - 1; u <= x + 1; ++u) all = all && tiles[size_t{v} * side + u];
      out[size_t{y} * side + x] = all ? 1 : 0;
    }
  return out;
}

}  // namespace nepho
