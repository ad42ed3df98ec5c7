#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "common/frame.h"
#include "scene/shadow_params.h"

namespace nepho {

/// A camera's distances that one cascade of shadow maps serves.
struct ShadowSlice {
  double near_m = 0.0;
  double fade_m = 0.0;  ///< from here on it gives way to the next
  double far_m = 0.0;
};

/// Far range for a camera at this height, m: tens of kilometres on the ground, the visible disc from orbit. `top_m` is
/// that of the clouds.
double automatic_shadow_range_m(double camera_height_m, double top_m);

/// The slices up to `far_m`: uniform, logarithmic, or practical, a mix of both (Zhang et al. 2006). `nearest_m`: no
/// closer cloud or ground can be seen; the first slice starts there or at the camera.
std::vector<ShadowSlice> shadow_slices(const CloudShadowParams& params, double nearest_m, double far_m);

/// The smallest ball about a slice of a cone of view, its centre on the axis. It is the same wherever the camera looks.
struct SliceBall {
  double ahead_m = 0.0;  ///< of its centre before the camera
  double radius_m = 0.0;
};
SliceBall ball_of_slice(double near_m, double far_m, double half_angle_rad);

/// A frame of reference across the light: unit vectors, ECEF axes; the same light, the same frame.
struct LightAxes {
  glm::dvec3 x{1, 0, 0}, y{0, 1, 0}, light{0, 0, 1};
  static LightAxes towards(const glm::dvec3& light);
};

/// A square of tiles in the plane across the light, on a grid that starts at the Earth's centre.
struct ShadowGrid {
  int64_t first_x = 0, first_y = 0;  ///< of the window's first tile
  uint32_t tiles = 64;               ///< along a side
  double tile_m = 1.0;
};

/// Which tiles of a window light may pass through on its way to what a frame shows: the part of the pyramid of view at
/// distances from near_m to far_m and at geodetic heights from low_m to high_m. Row by row; 0, or 1 in those and their
/// neighbours.
std::vector<uint8_t> tiles_in_view(const shared::FrameConstants& frame, const glm::dvec3& camera_ecef_m,
                                   const LightAxes& axes, const ShadowGrid& grid, double near_m, double far_m,
                                   double low_m, double high_m);

/// One more tile to all sides.
std::vector<uint8_t> widened(const std::vector<uint8_t>& tiles, uint32_t side);
/// Those whose eight neighbours are in it as well; at the window's rim, those inside.
std::vector<uint8_t> surrounded(const std::vector<uint8_t>& tiles, uint32_t side);

}  // namespace nepho
