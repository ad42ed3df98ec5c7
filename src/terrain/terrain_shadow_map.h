#pragma once
#include <atomic>
#include <future>
#include <vector>

#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/height_sampler.h"
#include "terrain/terrain_shadow_shared.h"
#include "terrain/terrain_volume.h"

namespace nepho {

/// Heights of the ground around a camera in nested maps, with the highest ground of ever larger cells: what
/// shaders/terrain/terrain_shadow.glsl marches towards the light (docs/light.md, 'Terrain shadows').
class TerrainShadowMap {
 public:
  explicit TerrainShadowMap(gpu::Device& device) : device_(device) {}
  ~TerrainShadowMap();
  TerrainShadowMap(const TerrainShadowMap&) = delete;
  TerrainShadowMap& operator=(const TerrainShadowMap&) = delete;

  /// Whether terrain may shade anything that a camera sees: not where the ground is even to a metre within the map, nor
  /// from near the ground when the key light is higher than any slope leans or far below the horizon. Samples the
  /// heights around the camera first, unless the map at hand still serves. `in_background`: a map that serves no longer
  /// stays until the next one is made, which takes some frames.
  bool update(const HeightSampler& heights, const FrameInfo& frame, bool in_background = false);
  /// The same around a given map, whatever the light.
  void update(const HeightSampler& heights, const shared::RegionMap& map);

  struct Refs {
    ImageRef heights;     ///< r32f, a layer per level
    BufferRef constants;  ///< TerrainShadowConstants
    explicit operator bool() const { return static_cast<bool>(heights); }
  };
  Refs import_into(FrameGraph& graph) const;

  /// How high shadows reach over every place of the map: shaders/terrain/terrain_volume.glsl. Made anew where the map
  /// or the frame's key light is another than before. `sequence`: the picture follows the last one; then a light that
  /// turns slowly is followed in steps of 0.05 degrees, one level a frame.
  TerrainVolumeRefs add_volume(FrameGraph& graph, const FrameInfo& frame, bool sequence = false);
  /// Geodetic height that no shadow on this side of the planet's own reaches.
  double shade_top_m(const FrameInfo& frame) const;
  const shared::TerrainShadowConstants& constants() const { return constants_; }

 private:
  /// A map before it is on the GPU.
  struct Made {
    shared::RegionMap map{};
    std::vector<std::vector<std::vector<float>>> mips;  ///< by level; those that are missing have none yet
    float lowest_m = 0.0f, highest_m = 0.0f;
  };
  static Made make(const HeightSampler& heights, const shared::RegionMap& map);
  void show(const Made& made);

  gpu::Device& device_;
  const HeightSampler* heights_ = nullptr;
  gpu::Image image_;
  shared::TerrainShadowConstants constants_{};
  float lowest_m_ = 0.0f;
  gpu::ComputePipeline bake_, bake_lit_;
  gpu::Image volume_, lit_;
  std::vector<glm::vec3> volume_lights_;  ///< by level; those that are missing have none yet
  bool draft_ = false;                    ///< what is shown lacks what would have taken long to read
  std::atomic<bool> stop_{false};         ///< ends `next_`
  std::future<Made> next_;                ///< being made in the background
};

/// Binds what terrain_shadow.glsl reads.
void bind_terrain_shadow(FrameGraph::PassBuilder& pass, const TerrainShadowMap::Refs& refs);

/// All mips of one level as the shader wants them, finest first: `mips[0]` the heights, row by row. `inside`: mip 0 of
/// the next finer level with everything inside that one taken into account, or empty; returns this level's.
std::vector<float> highest_around(std::vector<float> heights, const std::vector<float>& inside,
                                  std::vector<std::vector<float>>& mips);

}  // namespace nepho
