#include "geo/cube_sphere.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace nepho {

CubePointD cube_from_direction(const dvec3& dir) {
  const dvec3 m = glm::abs(dir);
  CubePointD p;
  dvec3 c;
  if (m.z >= m.x && m.z >= m.y) {
    p.face = dir.z >= 0.0 ? 4u : 5u;
    c = dvec3(dir.z >= 0.0 ? dir.x : -dir.x, -dir.y, m.z);
  } else if (m.y >= m.x) {
    p.face = dir.y >= 0.0 ? 2u : 3u;
    c = dvec3(dir.x, dir.y >= 0.0 ? dir.z : -dir.z, m.y);
  } else {
    p.face = dir.x >= 0.0 ? 0u : 1u;
    c = dvec3(dir.x >= 0.0 ? -dir.z : dir.z, -dir.y, m.x);
  }
  p.uv = glm::dvec2(0.5 * (c.x / c.z + 1.0), 0.5 * (c.y / c.z + 1.0));
  return p;
}

dvec3 direction_from_cube(uint32_t face, const glm::dvec2& uv) {
  const double s = 2.0 * uv.x - 1.0, t = 2.0 * uv.y - 1.0;
  const double major = (face & 1u) == 0u ? 1.0 : -1.0;
  switch (face >> 1u) {
    case 0:
      return glm::normalize(dvec3(major, -t, -major * s));
    case 1:
      return glm::normalize(dvec3(s, major, major * t));
    default:
      return glm::normalize(dvec3(major * s, -t, major));
  }
}

namespace {
double warp(double x) { return std::abs(x) == 1.0 ? x : std::atan(x) * (4.0 / std::numbers::pi); }
double unwarp(double x) { return std::abs(x) == 1.0 ? x : std::tan(x * (std::numbers::pi / 4.0)); }

// Solid angle of the face's part between its centre and (s, t), both -1..1 (signed).
double corner_solid_angle(double s, double t) { return std::atan2(s * t, std::sqrt(s * s + t * t + 1.0)); }
}  // namespace

glm::dvec2 cube_warp_uv(const glm::dvec2& uv) {
  return {0.5 * (warp(2.0 * uv.x - 1.0) + 1.0), 0.5 * (warp(2.0 * uv.y - 1.0) + 1.0)};
}

glm::dvec2 cube_unwarp_uv(const glm::dvec2& uv) {
  return {0.5 * (unwarp(2.0 * uv.x - 1.0) + 1.0), 0.5 * (unwarp(2.0 * uv.y - 1.0) + 1.0)};
}

double cube_solid_angle(const glm::dvec2& uv_min, const glm::dvec2& uv_max) {
  const double s0 = 2.0 * uv_min.x - 1.0, s1 = 2.0 * uv_max.x - 1.0;
  const double t0 = 2.0 * uv_min.y - 1.0, t1 = 2.0 * uv_max.y - 1.0;
  return corner_solid_angle(s1, t1) - corner_solid_angle(s0, t1) - corner_solid_angle(s1, t0) +
         corner_solid_angle(s0, t0);
}

}  // namespace nepho
