#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "atmosphere/atmosphere_tables.h"
#include "clouds/cloud_pixel_list.h"
#include "clouds/shadow_map.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "render/shaft_shared.h"
#include "scene/shaft_params.h"
#include "terrain/terrain_volume.h"

namespace nepho {

/// How a picture finds the shade of clouds in the air.
enum class ShaftMethod { none, shadow_length, froxel, screen };
ShaftMethod shaft_method(const ShaftParams& params, const std::string& quality);

/// What shaders know of layers of haze: heights in the camera's scaled space, over a planet of this radius.
shared::HazeData make_haze_data(const std::vector<HazeLayer>& haze, const shared::PlanetView& planet,
                                float air_radius_m);

/// The frustum grid of air and haze: what lies before any point that the camera sees.
struct FroxelRefs {
  ImageRef change;         ///< rgb: what shade and haze change; a: transmittance of the haze
  ImageRef light;          ///< luminance of the air, shaded and hazy; empty where it was not asked for
  ImageRef transmittance;  ///< of air and haze; with it
  BufferRef grid;
  shared::FroxelGrid data;
};
/// Binds them to a pass whose shader includes render/froxel_air.glsl.
void bind_froxels(FrameGraph::PassBuilder& pass, const FroxelRefs& refs);

/// Changes background and clouds by what the air in the shade of clouds does not send, and by haze (docs/light.md).
/// Reads depth, clouds' depth, the clouds' shadow maps and the atmosphere. Writes background and cloud radiance anew.
class ShaftPass {
 public:
  /// Of a frame's air.
  struct Air {
    AtmosphereTables::Refs atmosphere;
    const shared::AtmosphereUniform* uniform = nullptr;
    CloudShadowRefs shadow;          ///< may be empty: no shade of clouds
    TerrainVolumeRefs terrain = {};  ///< may be empty: none of terrain
    double terrain_top_m = 0.0;      ///< with it: geodetic height that its shadows do not reach
    double cloud_top_m = 0.0;        ///< geodetic height that no cloud reaches
    double ground_m = 0.0;           ///< geodetic height of the ground around the camera
    double ground_albedo = 0.1;
    bool sequence = false;  ///< the picture is one of many: shade is looked for less often
  };
  struct Inputs {
    ImageRef depth_m;
    ImageRef background;
    ImageRef cloud;            ///< premultiplied; may be empty: no clouds
    ImageRef cloud_near;       ///< with it: CloudMarchPass::Outputs::near
    ImageRef cloud_depths;     ///< and ::depths
    FroxelRefs froxels;        ///< of add_froxels(), where the method is froxel
    CloudPixelList list = {};  ///< where `cloud` and `cloud_near` are this frame's; empty: everywhere
  };
  struct Outputs {
    ImageRef background, cloud;
  };
  ShaftPass(gpu::Device& device, uint32_t spectral_groups);

  /// The uniform block `shafts` of shaders that know haze (render/haze_ground.glsl).
  BufferRef add_constants(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params, const HazeParams& haze,
                          const Air& air) const {
    return constants(graph, frame, params, drawn_haze(haze), kNoShade_m, air);
  }
  /// Fills the frustum grid; needs nothing of what the camera sees. `light`: luminance and transmittance as well.
  FroxelRefs add_froxels(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params, const HazeParams& haze,
                         ShaftMethod method, const Air& air, bool light);
  /// Where there is neither haze nor shade it adds no pass and gives its inputs back.
  Outputs add(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params, const HazeParams& haze,
              ShaftMethod method, const Air& air, const Inputs& in);

 private:
  static constexpr double kNoShade_m = -1e6;
  enum Kind : uint32_t { shadow_march, screen_march, haze_march, apply, shadow_fill, haze_fill, froxel_apply };
  /// Low-resolution images of what is to be changed.
  struct Blocks {
    ImageRef near, far, cloud_near, cloud_far, depths;
  };
  Blocks add_march(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                   const std::vector<HazeLayer>& haze, ShaftMethod method, const Air& air, const Inputs& in);
  /// What the pass "apply" is to change.
  enum Part : uint32_t { all_parts, background_part, cloud_part };
  BufferRef constants(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                      const std::vector<HazeLayer>& haze, double shade_top_m, const Air& air) const;
  const gpu::ComputePipeline& pipeline(Kind kind, uint32_t haze_layers = 0, uint32_t steps = 0, uint32_t more = 0,
                                       bool terrain = false, bool quick = false);
  void bind_terrain(FrameGraph& graph, FrameGraph::PassBuilder& pass, const TerrainVolumeRefs& terrain) const;
  gpu::Device& device_;
  uint32_t spectral_groups_;
  std::map<std::array<uint32_t, 6>, gpu::ComputePipeline> pipelines_;
  gpu::Image no_terrain_;
};

}  // namespace nepho
