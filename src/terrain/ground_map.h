#pragma once
#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "terrain/ground_texels.h"

namespace nepho {

/// Albedo, height and water of the ground around a place, coarse, on the GPU: for light that clouds scattered and that
/// then meets ground which the picture may not show. Looked up by shaders/terrain/ground_map.glsl.
class GroundMap {
 public:
  explicit GroundMap(gpu::Device& device) : device_(device) {}

  /// Samples the ground on `map`'s nested levels (GroundTexels). Does nothing when the map and the samplers are those
  /// of last time.
  void update(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map);

  struct Refs {
    ImageRef albedo;    ///< rgba16f, a layer per level: GroundTexels::albedo
    ImageRef height_m;  ///< r32f, a layer per level
  };
  /// After update(). Sample both with Sampler::linear_clamp, as `ground_albedo_tex` and `ground_height_tex`.
  Refs import_into(FrameGraph& graph) const;
  /// The map of the last update(); no levels before.
  const shared::RegionMap& map() const { return map_; }
  static constexpr uint32_t kTexels = GroundTexels::kSide;

 private:
  gpu::Device& device_;
  shared::RegionMap map_{};
  const HeightSampler* heights_ = nullptr;
  const ImagerySampler* imagery_ = nullptr;
  gpu::Image albedo_, height_;
};

}  // namespace nepho
