#pragma once
#include <map>

#include "gpu/frame_graph.h"
#include "gpu/pipeline.h"
#include "scene/scene.h"

namespace nepho {

/// Exposure, tone curve and sRGB encoding (docs/exposure.md).
/// Reads scene-linear radiance. Writes an 8-bit picture and the exposure that was used. Keeps the exposure of the last
/// picture, from which automatic exposure adapts.
class ExposurePasses {
 public:
  struct Outputs {
    ImageRef display;  ///< rgba8, sRGB encoded
    BufferRef state;   ///< shared::ExposureState
  };
  explicit ExposurePasses(gpu::Device& device);
  /// `frame_interval_s`: since the last picture; 0 for a still, whose automatic exposure is the metered one at once.
  Outputs add(FrameGraph& graph, ImageRef radiance, const RenderParams& params, double frame_interval_s = 0.0);

 private:
  const gpu::ComputePipeline& tonemap_for(uint32_t curve);
  gpu::Device& device_;
  gpu::ComputePipeline histogram_, reduce_;
  std::map<uint32_t, gpu::ComputePipeline> tonemap_;  // by curve, made when first used
  gpu::Buffer adapted_;                               // shared::ExposureState, zero before the first picture
};

}  // namespace nepho
