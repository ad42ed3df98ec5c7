#pragma once
#include "clouds/cloud_density.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Vertical optical depths of a square of columns around the point below the camera, by the march's own density.
class CloudColumns {
 public:
  explicit CloudColumns(gpu::Device& device);
  struct Square {
    glm::vec3 east{1, 0, 0}, north{0, 1, 0};  ///< at the camera, ECEF axes
    double side_m = 300e3;
    double footprint_m = 10.0;  ///< smaller detail is averaged
    uint32_t count = 64;        ///< columns along a side, northernmost row first
  };
  /// r32f, count x count.
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, const Square& square) const;

 private:
  gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
