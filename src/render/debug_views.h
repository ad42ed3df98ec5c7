#pragma once
#include <array>
#include <string>
#include <vector>

#include "clouds/cloud_march_pass.h"
#include "clouds/shadow_map.h"

namespace nepho {

/// Names of the false-colour pictures that RenderRequest::debug takes; docs/debug_views.md has their legends.
std::vector<std::string> known_debug_views();

/// Draws one of them from what the march left. Reads the clouds' radiance and facts, the distance to the surface and
/// the cloud density. Writes rgba8, sRGB values.
class DebugViewPass {
 public:
  /// `clouds` must outlive the pass.
  DebugViewPass(gpu::Device& device, const Clouds& clouds) : device_(device), clouds_(clouds) {}
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const std::string& view, ImageRef depth_m,
               const CloudDensityRefs& density, const CloudMarchPass::Outputs& marched,
               const CloudShadowRefs& shadow) const;
  /// Colour of a pixel without clouds, 0..255.
  static std::array<uint8_t, 3> clear_color(const std::string& view);

 private:
  gpu::Device& device_;
  const Clouds& clouds_;
  mutable gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
