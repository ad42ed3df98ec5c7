#pragma once
#include "clouds/clouds.h"
#include "gpu/frame_info.h"

namespace nepho {

/// What shaders that include clouds/cloud_density.glsl read.
struct CloudDensityRefs {
  BufferRef constants;
  WeatherMap::Refs weather;
  CloudNoise::Refs noise;
};

/// Imports textures and uploads the constants, once per frame.
CloudDensityRefs import_cloud_density(FrameGraph& graph, const FrameInfo& frame, const Clouds& clouds);

/// Binds them to a pass whose shader includes clouds/cloud_density.glsl.
void bind_density(FrameGraph::PassBuilder& pass, const CloudDensityRefs& refs);

}  // namespace nepho
