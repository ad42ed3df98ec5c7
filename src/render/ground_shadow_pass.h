#pragma once
#include "clouds/cloud_density.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/terrain.h"

namespace nepho {

/// Shadows of clouds on the surface, by a short march towards the sun at every pixel.
/// Reads the surface's depth and the cloud density. Writes the share of sunlight that arrives, r32f.
class GroundShadowPass {
 public:
  explicit GroundShadowPass(gpu::Device& device);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
               const CloudDensityRefs& density) const;

 private:
  gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
