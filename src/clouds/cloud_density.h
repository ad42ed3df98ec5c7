#pragma once
#include "clouds/cloud_noise.h"
#include "clouds/clouds_shared.h"
#include "gpu/frame_info.h"
#include "scene/cloud_params.h"
#include "weather/weather_map.h"

namespace nepho {

/// Of what lies below clouds, for light from under them.
inline constexpr float kGroundAlbedo = 0.15f;

/// What shaders that include clouds/cloud_density.glsl read.
struct CloudDensityRefs {
  BufferRef constants;
  ImageRef weather;
  CloudNoise::Refs noise;
};

/// True when these parameters draw nothing: no coverage, or a first layer without thickness or extinction.
bool draws_nothing(const CloudParams& params);

/// The uniform block `cloud` of one frame. Noise coordinates of the camera are reduced in double.
shared::CloudConstants make_cloud_constants(const FrameInfo& frame, const CloudParams& params, const CloudNoise& noise,
                                            const WeatherMap& weather);

/// Imports textures and uploads the constants, once per frame.
CloudDensityRefs import_cloud_density(FrameGraph& graph, const FrameInfo& frame, const CloudParams& params,
                                      const CloudNoise& noise, const WeatherMap& weather);

/// Binds them to a pass whose shader includes clouds/cloud_density.glsl.
void bind_density(FrameGraph::PassBuilder& pass, const CloudDensityRefs& refs);

}  // namespace nepho
