#pragma once
#include "gpu/frame_graph.h"
#include "gpu/pipeline.h"
#include "scene/scene.h"

namespace nepho {

/// Exposure, tone curve and sRGB encoding.
/// Reads scene-linear radiance. Writes an 8-bit picture and the exposure that was used. Keeps nothing.
class ExposurePasses {
 public:
  struct Outputs {
    ImageRef display;  ///< rgba8, sRGB encoded
    BufferRef state;   ///< shared::ExposureState
  };
  explicit ExposurePasses(gpu::Device& device);
  Outputs add(FrameGraph& graph, ImageRef radiance, const RenderParams& params) const;

 private:
  gpu::ComputePipeline histogram_, reduce_, tonemap_;
};

}  // namespace nepho
