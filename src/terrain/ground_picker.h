#pragma once
#include <optional>

#include "gpu/frame_info.h"
#include "terrain/ray_caster.h"
#include "terrain/terrain.h"

namespace nepho {

/// What a picture's pixels show of the ground, found on the CPU from the very triangles that the frame draws. Made
/// after Terrain::prepare() of the same frame; stays as it is when the terrain moves on. Thread-safe once made.
class GroundPicker {
 public:
  GroundPicker(const Terrain& terrain, const FrameInfo& frame);

  /// Unit direction, ECEF axes, through a place in the picture: pixel centres have .5, (0, 0) is the upper left corner.
  dvec3 ray(double x_px, double y_px) const;
  /// The ground there; empty: sky. Places outside the picture may be missed, as their tiles are not drawn.
  std::optional<GroundHit> at(double x_px, double y_px) const;

 private:
  shared::FrameConstants frame_;
  RayCaster caster_;
};

}  // namespace nepho
