#pragma once
#include "clouds/shadow_map.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/terrain.h"

namespace nepho {

/// Shadows of clouds on the surface of every pixel. Reads the surface's depth and the clouds' shadow maps. Writes the
/// share of the key light that arrives, r32f.
class GroundShadowPass {
 public:
  explicit GroundShadowPass(gpu::Device& device);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
               const CloudShadowRefs& shadow) const;

  struct Shown {
    ImageRef depth_m;         ///< of the surface
    ImageRef visibility;      ///< what add() gave
    ImageRef cloud_radiance;  ///< as CloudMarchPass gives them
    ImageRef cloud_info;
  };
  /// For pictures with layers, rg32f, in every pixel: the share of the key light that clouds let through to the surface
  /// (1 in the sky), and to what hides more than half of it: the clouds at their mean depth.
  ImageRef add_layers(FrameGraph& graph, const FrameInfo& frame, const Shown& shown,
                      const CloudShadowRefs& shadow) const;

 private:
  gpu::Device& device_;
  gpu::ComputePipeline pipeline_;
  mutable gpu::ComputePipeline layers_;  ///< made when a frame needs it
};

}  // namespace nepho
