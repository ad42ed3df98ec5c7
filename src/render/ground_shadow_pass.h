#pragma once
#include <array>

#include "clouds/cloud_density.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/terrain.h"

namespace nepho {

/// Shadows of clouds on the surface, by a short march towards the sun at every pixel.
/// Reads the surface's depth and the cloud density. Writes the share of sunlight that arrives, r32f.
class GroundShadowPass {
 public:
  /// `clouds` must outlive the pass.
  GroundShadowPass(gpu::Device& device, const Clouds& clouds) : device_(device), clouds_(clouds) {}
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
               const CloudDensityRefs& density) const;

 private:
  gpu::Device& device_;
  const Clouds& clouds_;
  mutable std::array<gpu::ComputePipeline, 2> pipeline_;  ///< by phases - 1, made when a frame needs it
};

}  // namespace nepho
