#pragma once
#include "atmosphere/atmosphere_tables.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "terrain/terrain.h"

namespace nepho {

/// Shades the surface, the sky and the sun's disc as seen through clear air.
/// Reads the terrain's images, the atmosphere tables and, where there are clouds, their shadow on the surface. Writes
/// radiance.
class BackgroundPass {
 public:
  struct Inputs {
    Terrain::Outputs terrain;
    AtmosphereTables::Refs atmosphere;
    ImageRef sun_visibility;  ///< may be empty: no clouds
  };
  explicit BackgroundPass(gpu::Device& device);
  ImageRef add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereParams& params, const Inputs& in) const;

 private:
  gpu::ComputePipeline pipeline_;
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
