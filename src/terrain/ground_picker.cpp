#include "terrain/ground_picker.h"

#include <glm/geometric.hpp>

namespace nepho {

GroundPicker::GroundPicker(const Terrain& terrain, const FrameInfo& frame)
    : frame_(frame.constants), caster_(frame.camera_ecef_m, terrain.selected(), [&terrain](const SelectedTile& tile) {
        return terrain.drawn_positions(tile);
      }) {}

dvec3 GroundPicker::ray(double x_px, double y_px) const {
  // pixel_direction() of shaders/common/frame.h in double, from the same numbers.
  const double x = 2.0 * (x_px + static_cast<double>(frame_.jitter_px.x)) / frame_.size.x - 1.0;
  const double y = 1.0 - 2.0 * (y_px + static_cast<double>(frame_.jitter_px.y)) / frame_.size.y;
  return glm::normalize(dvec3(frame_.forward) + x * dvec3(frame_.right) + y * dvec3(frame_.up));
}

std::optional<GroundHit> GroundPicker::at(double x_px, double y_px) const {
  const dvec3 dir = ray(x_px, y_px);
  return caster_.first_hit(dir, static_cast<double>(frame_.near_m) / glm::dot(dir, dvec3(frame_.forward)));
}

}  // namespace nepho
