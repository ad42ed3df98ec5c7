#pragma once
#include <glm/vec3.hpp>

#include "common/frame.h"
#include "gpu/frame_graph.h"

namespace nepho {

/// What every pass of one frame is given.
struct FrameInfo {
  Extent2D extent;                   ///< px
  shared::FrameConstants constants;  ///< as uploaded
  BufferRef buffer;                  ///< the same, bound as uniform `frame`
  glm::dvec3 camera_ecef_m{0.0};     ///< double: shaders only know camera-relative floats
  double time_s = 0.0;               ///< seconds since 2000-01-01T00:00:00 UTC
};

}  // namespace nepho
