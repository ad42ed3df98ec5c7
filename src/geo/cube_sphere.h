#pragma once
#include <cstdint>
#include <glm/vec2.hpp>

#include "common/cube_sphere.h"
#include "geo/geodetic.h"

namespace nepho {

/// Double-precision twins of shaders/common/cube_sphere.h: the same faces, the same (u, v), the same ties.
struct CubePointD {
  uint32_t face = 0;        ///< 0..5: +X, -X, +Y, -Y, +Z, -Z
  glm::dvec2 uv{0.5, 0.5};  ///< gnomonic, 0..1, exactly 0 or 1 on edges
};

/// Face and (u, v) of a direction of any length but 0.
CubePointD cube_from_direction(const dvec3& dir);
/// Unit direction at gnomonic (u, v) of a face.
dvec3 direction_from_cube(uint32_t face, const glm::dvec2& uv);

/// Tangent-warped (u, v) of a gnomonic one, s' = 4/pi atan(s), and back.
glm::dvec2 cube_warp_uv(const glm::dvec2& uv);
glm::dvec2 cube_unwarp_uv(const glm::dvec2& uv);

/// Solid angle (sr) of the part of a face between two gnomonic (u, v); a whole face has 4 pi / 6.
double cube_solid_angle(const glm::dvec2& uv_min, const glm::dvec2& uv_max);

}  // namespace nepho
