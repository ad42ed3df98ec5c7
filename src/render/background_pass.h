#pragma once
#include <array>

#include "atmosphere/atmosphere_tables.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "render/night_sky.h"
#include "terrain/terrain.h"

namespace nepho {

/// Shades the surface, the sky, sun, moon and stars as seen through clear air.
/// Reads the terrain's images, the atmosphere tables, the night sky and, where there are clouds, their shadow on the
/// surface. Writes radiance.
class BackgroundPass {
 public:
  struct Inputs {
    Terrain::Outputs terrain;  ///< all empty: the camera, within the air, sees nothing but sky
    AtmosphereTables::Refs atmosphere;
    NightSky::Refs night_sky;
    bool night = true;        ///< false: by day, when stars and airglow cannot be seen
    ImageRef sun_visibility;  ///< may be empty: no clouds
  };
  BackgroundPass(gpu::Device& device, uint32_t spectral_groups);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereParams& params, const Inputs& in) const;

 private:
  const gpu::ComputePipeline& pipeline(bool surfaces, bool night) const;

  gpu::Device& device_;
  uint32_t spectral_groups_;
  mutable std::array<gpu::ComputePipeline, 4> pipelines_;  ///< made when they are needed
};

/// Puts the clouds over the background.
class CompositePass {
 public:
  explicit CompositePass(gpu::Device& device);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, ImageRef background, ImageRef cloud_radiance) const;

 private:
  gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
