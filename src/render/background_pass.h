#pragma once
#include <array>
#include <map>
#include <optional>

#include "atmosphere/air_volume.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "render/night_sky.h"
#include "render/render_shared.h"
#include "terrain/terrain.h"

namespace nepho {

inline constexpr float kNightLight_cd_m2 = 8.0f;  ///< city centres seen from above (VIIRS: some 1e-7 W/cm2/sr)

/// Shades the surface, the sky, stars, sun and moon as seen through clear air.
/// Reads the terrain's images, the atmosphere tables, the night sky and, where there are clouds, their shadow on the
/// surface. Writes radiance.
class BackgroundPass {
 public:
  struct Inputs {
    Terrain::Outputs terrain;
    AtmosphereTables::Refs atmosphere;
    AirVolume::Refs air_volume = {};  ///< may be empty: the air before surfaces is integrated
    NightSky::Refs night_sky;
    bool has_sky_view = true;   ///< the atmosphere has sky views of the camera
    bool night = true;          ///< false: by day, when stars and airglow cannot be seen
    ImageRef sun_visibility;    ///< may be empty: no clouds
    float wind_mps = 6.0f;      ///< over water (TerrainParams::water_wind_mps)
    BufferRef shafts = {};      ///< ShaftPass::add_constants(); empty: no haze
    uint32_t haze_layers = 0;   ///< of it
    ImageRef cloud_light = {};  ///< CloudLight::Refs::ground; empty: the sky is clear, or clouds are lit by octaves
  };
  BackgroundPass(gpu::Device& device, uint32_t spectral_groups);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereParams& params, const Inputs& in) const;

 private:
  enum Kind { surface, sky, discs };
  /// Made when it is needed: night and day differ.
  const gpu::ComputePipeline& pipeline(Kind kind, bool night, uint32_t haze_layers = 0, bool volume = false) const;
  void add_discs(FrameGraph& graph, const FrameInfo& frame, const Inputs& in, ImageRef background) const;

  gpu::Device& device_;
  uint32_t spectral_groups_;
  mutable std::map<std::array<uint32_t, 4>, gpu::ComputePipeline> pipelines_;
};

/// The pixels [first, last) that a disc of this angular radius around a direction may touch; nothing when it is outside
/// the picture.
std::optional<shared::DiscsPush> pixels_of_disc(const shared::FrameConstants& frame, const glm::vec3& dir,
                                                float angular_radius_rad);

/// Puts the clouds over the background.
class CompositePass {
 public:
  explicit CompositePass(gpu::Device& device);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, ImageRef background, ImageRef cloud_radiance) const;

 private:
  gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
