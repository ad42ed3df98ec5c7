#pragma once
#include <optional>

#include "clouds/cloud_pixel_list.h"
#include "clouds/clouds.h"
#include "clouds/upscale_shared.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"

namespace nepho {

/// How a frame looks back at the one before it. `wind_m`: way of the clouds between them, ECEF axes.
shared::UpscaleConstants make_upscale_constants(const FrameInfo& now, const FrameInfo& before, uint32_t upscale,
                                                uint32_t number, const glm::dvec3& wind_m);

/// True where a frame cannot be told from the one before it: another size, a number that does not follow, another field
/// of view, a jump of the clock, or a turn or a leap of the camera that no movement makes.
bool is_cut(const FrameInfo& now, const FrameInfo& before);

/// Temporal upscaling of the clouds (docs/performance.md): of 16, 4 or 2 pixels one is marched in a frame; the others
/// are what the last frames saw, moved to where it is now. Holds the last frame's camera; the pictures are histories of
/// the frame graph.
class CloudUpscaler {
 public:
  /// `clouds` must outlive it.
  CloudUpscaler(gpu::Device& device, const Clouds& clouds);

  /// What of a frame is to be marched.
  struct Selection {
    CloudPixelList list = {};  ///< empty: every pixel, because nothing is known of before
    FrameInfo frame = {};  ///< whose rays are moved within their pixels; for the march and the lighting of the clouds
    BufferRef constants = {};  ///< shared::UpscaleConstants
    ImageRef info = {},
             depths = {};    ///< CloudMarchPass::Outputs; holds guesses where nothing is marched. Empty without a list
    ImageRef radiance = {};  ///< guesses too, where they were asked for
    bool first() const { return !list; }
  };
  /// `upscale`: 16, 4 or 2. Once a frame, and resolve() after it. `guess_radiance`: fill Selection::radiance.
  Selection select(FrameGraph& graph, const FrameInfo& frame, uint32_t upscale, ImageRef depth_m, bool guess_radiance);

  struct Inputs {
    ImageRef depth_m;
    ImageRef cloud;  ///< premultiplied luminance with its air, shafts and haze; transmittance
    ImageRef info;   ///< CloudMarchPass::Outputs::info
  };
  struct Outputs {
    ImageRef cloud, info;
  };
  /// Clouds of every pixel. In a first frame they are the ones given.
  Outputs resolve(FrameGraph& graph, const FrameInfo& frame, const Selection& selection, const Inputs& in);
  /// The next frame marches every pixel: something but camera and clock has changed.
  void forget() { before_.reset(); }

 private:
  glm::dvec3 wind_mps(const FrameInfo& frame) const;
  const Clouds& clouds_;
  struct History {
    ImageRef radiance, place;
  } history_;  ///< in the graph of the frame at hand
  gpu::ComputePipeline select_, select_filling_, resolve_, first_;
  std::optional<FrameInfo> before_;
  uint32_t upscale_ = 1, number_ = 0;
};

}  // namespace nepho
