#pragma once
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "clouds/cloud_density.h"
#include "clouds/shadow_cascades.h"
#include "clouds/shadow_map_shared.h"
#include "gpu/pipeline.h"

namespace nepho {

/// What shaders that include clouds/shadow_map.glsl read.
struct CloudShadowRefs {
  BufferRef data;
  ImageRef map;
};

/// Binds them to a pass whose shader includes clouds/shadow_map.glsl.
void bind_cloud_shadow(FrameGraph::PassBuilder& pass, const CloudShadowRefs& refs);

/// Shadow maps of the clouds in the key light's view: up to four cascades of texels that hold the depths at which
/// optical depths are reached (shaders/clouds/shadow_map.glsl, docs/light.md).
/// Reads the cloud density. Keeps its maps from frame to frame and marches only tiles of them that the camera sees and
/// that are not there yet, or are out of date.
class CloudShadowMaps {
 public:
  /// `clouds` must outlive the maps.
  CloudShadowMaps(gpu::Device& device, const Clouds& clouds, const CloudShadowParams& params);
  /// Brings the maps up to date for a frame. Every call belongs to a graph that is run.
  CloudShadowRefs add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density);

  /// What the last add() did.
  struct Work {
    uint32_t needed = 0;   ///< tiles that the frame may read
    uint32_t marched = 0;  ///< tiles that the frame marches; 0: nothing is dispatched
  };
  const Work& work() const { return work_; }
  /// As the shader's uniform block has it; valid after add().
  const shared::ShadowMaps& data() const { return data_; }
  const gpu::Image& image() const { return image_; }

  /// How the march goes; for measurements.
  struct March {
    uint32_t detail = 0;      ///< noises: 1 billows, 2 turbulence as well, 3 all; 0: by the size of texels
    float step_scale = 1.0f;  ///< of its steps
    float footprint = 0.5f;   ///< in texels
  };
  void set_march(const March& march);
  /// Forgets all maps.
  void reset();

 private:
  /// A tile's storage: which tile of the grid it holds, as of when.
  struct Slot {
    int64_t x = 0, y = 0;
    double time_s = 0.0;
    uint32_t rounds = 0;  ///< 0: nothing
  };
  struct Cascade {
    double radius_m = 0.0;  ///< of what it serves
    double texel_m = 1.0;
    double depth_zero_m = 0.0;  ///< of stored depths, along the light from the Earth's centre
    ShadowGrid grid;
    std::vector<Slot> slots;  ///< by storage place
  };
  /// What a frame's work on one tile would be.
  struct Candidate {
    shared::ShadowTileWork tile;
    size_t slot;
    double age_s;
    uint32_t rounds;
  };
  void aim(const FrameInfo& frame);
  void fit(Cascade& cascade, const ShadowSlice& slice, const FrameInfo& frame, double& ahead_m) const;
  std::vector<Candidate> plan(const FrameInfo& frame);
  void add_march(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density,
                 const std::vector<shared::ShadowTileWork>& tiles, uint32_t detail, bool merge);
  uint32_t detail_of(const Cascade& cascade) const;
  gpu::Device& device_;
  const Clouds& clouds_;
  CloudShadowParams params_;
  March march_;
  double low_m_ = 0.0, high_m_ = 0.0;  ///< of casting layers
  double drift_mps_ = 0.0;             ///< fastest change of the sky
  LightAxes axes_;
  std::vector<Cascade> cascades_;
  gpu::Image image_;
  std::map<std::array<uint32_t, 3>, gpu::ComputePipeline> pipelines_;  ///< by phases, detail, merging
  shared::ShadowMaps data_{};
  BufferRef data_buffer_;
  Work work_;
};

}  // namespace nepho
