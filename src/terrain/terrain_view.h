#pragma once
// Inside src/terrain only.
#include <glm/geometric.hpp>

#include "gpu/frame_info.h"
#include "scene/scene.h"
#include "terrain/tile_volume.h"

namespace nepho {

/// The view of a frame's camera.
inline TerrainView view_of(const FrameInfo& frame, const TerrainParams& params, double deepest_land_m) {
  const shared::FrameConstants& c = frame.constants;
  TerrainView view;
  view.camera_ecef_m = frame.camera_ecef_m;
  view.forward = glm::normalize(dvec3(c.forward));
  view.right = dvec3(c.right);
  view.up = dvec3(c.up);
  view.pixel_angle_rad = static_cast<double>(c.pixel_angle_rad);
  view.screen_error_px = params.screen_error_px;
  view.deepest_land_m = deepest_land_m;
  return view;
}

}  // namespace nepho
