#pragma once
#include <array>

#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/terrain.h"
#include "terrain/terrain_shadow_map.h"

namespace nepho {

/// Shadows of terrain on the surface of every pixel (shaders/render/terrain_shadow.comp). Reads the surface's depth,
/// the heights around, where there is any shadow at all, and the share of the key light that clouds let through; writes
/// that times the share past terrain, r32f.
class TerrainShadowPass {
 public:
  explicit TerrainShadowPass(gpu::Device& device) : device_(device) {}
  /// `lit`: TerrainVolumeRefs::lit. `cloud_share`: r32f, may be empty.
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
               const TerrainShadowMap::Refs& shadow, ImageRef lit, ImageRef cloud_share) const;

 private:
  gpu::Device& device_;
  mutable std::array<gpu::ComputePipeline, 2> pipelines_;  ///< without and with clouds, made when a frame needs them
};

}  // namespace nepho
