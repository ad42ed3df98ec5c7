#pragma once
#include <atomic>
#include <future>

#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "terrain/ground_texels.h"

namespace nepho {

/// Albedo, height and water of the ground around a place, coarse, on the GPU: for light that clouds scattered and that
/// then meets ground which the picture may not show. Looked up by shaders/terrain/ground_map.glsl.
class GroundMap {
 public:
  explicit GroundMap(gpu::Device& device) : device_(device) {}

  ~GroundMap();
  GroundMap(const GroundMap&) = delete;
  GroundMap& operator=(const GroundMap&) = delete;

  enum class Follow {
    exactly,        ///< the map is the wanted one
    near,           ///< one that still serves stays: pictures of a sequence, whose camera moves a little each time
    in_background,  ///< and one that serves no longer, until the next is made, which takes some frames
  };
  /// Samples the ground on `map`'s nested levels (GroundTexels), where that is needed. Does nothing when the map and
  /// the samplers are those of last time.
  void update(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map,
              Follow follow = Follow::exactly);

  struct Refs {
    ImageRef albedo;    ///< rgba16f, a layer per level: GroundTexels::albedo
    ImageRef height_m;  ///< r32f, a layer per level
  };
  /// After update(). Sample both with Sampler::linear_clamp, as `ground_albedo_tex` and `ground_height_tex`.
  Refs import_into(FrameGraph& graph) const;
  /// The map that is there, the last update()'s or one near it; no levels before.
  const shared::RegionMap& map() const { return map_; }
  static constexpr uint32_t kTexels = GroundTexels::kSide;

 private:
  /// A map before it is on the GPU.
  struct Made {
    shared::RegionMap map{};
    GroundTexels texels;
  };
  void show(const Made& made);

  gpu::Device& device_;
  shared::RegionMap map_{};
  const HeightSampler* heights_ = nullptr;
  const ImagerySampler* imagery_ = nullptr;
  gpu::Image albedo_, height_;
  std::atomic<bool> stop_{false};  ///< ends `next_`
  std::future<Made> next_;         ///< being made in the background
};

}  // namespace nepho
