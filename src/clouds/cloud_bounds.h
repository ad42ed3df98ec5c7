#pragma once
#include "clouds/cloud_density.h"
#include "clouds/path_shared.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Majorants of the clouds' extinction around a place, for tracking without bias (shaders/clouds/cloud_bounds.comp,
/// docs/reference.md): nested maps of columns, cut into slices within the bands of height that hold layers.
class CloudBoundsMap {
 public:
  /// `clouds` must outlive the map.
  CloudBoundsMap(gpu::Device& device, const Clouds& clouds);

  enum class Detail {
    density,  ///< of what the density can be in each texel
    layers,   ///< of what the layers can be anywhere in them: to see what the rest saves
  };
  /// Makes the majorants of a moment around `map` (its half_m and levels are taken as they are). What add() then
  /// records belongs to that moment and frame.
  void add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, const shared::RegionMap& map,
           Detail detail = Detail::density);
  /// Instead of add(): one majorant everywhere between two geodetic heights, and nothing elsewhere. Needs no map.
  void set_even(double low_m, double high_m, double most_per_m);
  /// As the shader's uniform block has it; valid after add().
  const shared::CloudBounds& data() const { return data_; }
  const gpu::Image& image() const { return image_; }

 private:
  gpu::Device& device_;
  const Clouds& clouds_;
  std::vector<gpu::ComputePipeline> bounds_;  ///< by phases - 1
  gpu::ComputePipeline runs_;
  gpu::Image image_;
  shared::CloudBounds data_{};
};

/// The bands of height that hold all layers, cut into about `slices` slices; without a map.
shared::CloudBounds cloud_bands(const Clouds& clouds, uint32_t slices = shared::kBoundsSlices);

/// The nested maps that a camera's clouds want: centred where it looks on the ground from far above, else below it;
/// as wide as it can see clouds up to `top_m`.
shared::RegionMap cloud_region(const shared::FrameConstants& frame, const glm::dvec3& camera_ecef_m, double top_m);

}  // namespace nepho
