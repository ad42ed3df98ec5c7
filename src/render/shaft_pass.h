#pragma once
#include <map>
#include <string>

#include "atmosphere/atmosphere_tables.h"
#include "clouds/shadow_map.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "render/shaft_shared.h"
#include "scene/shaft_params.h"

namespace nepho {

/// How a picture finds the shade of clouds in the air.
enum class ShaftMethod { none, shadow_length, froxel, screen };
ShaftMethod shaft_method(const ShaftParams& params, const std::string& quality);

/// What the passes of shafts and haze know of a scene's air: layers of haze, tops of clouds, light below. `cloud_top_m`
/// and `ground_m` are geodetic heights; a cloud top far below the ground means no shade.
shared::ShaftData make_shaft_data(const ShaftParams& params, const std::vector<HazeLayer>& haze,
                                  const shared::PlanetView& planet, float air_radius_m, double cloud_top_m,
                                  double ground_m, double ground_albedo);

/// Changes background and clouds by what the air in the shade of clouds does not send, and by haze (docs/light.md).
/// Reads depth, clouds' depth, the clouds' shadow maps and the atmosphere. Writes background and cloud radiance anew.
class ShaftPass {
 public:
  struct Inputs {
    ImageRef depth_m;
    ImageRef background;
    ImageRef cloud;       ///< premultiplied; may be empty: no clouds
    ImageRef cloud_info;  ///< with it
    AtmosphereTables::Refs atmosphere;
    CloudShadowRefs shadow;    ///< may be empty: no shade
    double cloud_top_m = 0.0;  ///< geodetic height that no cloud reaches
    double ground_m = 0.0;     ///< geodetic height of the ground around
    double ground_albedo = 0.1;
    const shared::AtmosphereUniform* air = nullptr;
  };
  ShaftPass(gpu::Device& device, uint32_t spectral_groups) : device_(device), spectral_groups_(spectral_groups) {}
  struct Outputs {
    ImageRef background, cloud;
  };
  /// Where there is neither haze nor shade it adds no pass and gives its inputs back.
  Outputs add(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params, const HazeParams& haze,
              ShaftMethod method, const Inputs& in);

 private:
  enum Kind { shadow_march, haze_march, apply };
  const gpu::ComputePipeline& pipeline(Kind kind, uint32_t haze_layers, uint32_t steps);
  gpu::Device& device_;
  uint32_t spectral_groups_;
  std::map<std::array<uint32_t, 3>, gpu::ComputePipeline> pipelines_;
};

}  // namespace nepho
