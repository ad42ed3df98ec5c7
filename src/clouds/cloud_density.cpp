#include "clouds/cloud_density.h"

namespace nepho {

CloudDensityRefs import_cloud_density(FrameGraph& graph, const FrameInfo& frame, const Clouds& clouds) {
  shared::CloudConstants constants = clouds.constants();
  constants.anchor = clouds.anchor(frame.camera_ecef_m, frame.time_s);
  return {.constants = graph.constants("clouds.constants", constants),
          .weather = clouds.weather().import_into(graph),
          .noise = clouds.noise().import_into(graph)};
}

void bind_density(FrameGraph::PassBuilder& pass, const CloudDensityRefs& refs) {
  pass.uniform("cloud", refs.constants)
      .sample("cloud_weather", refs.weather.coverage)
      .sample("cloud_properties", refs.weather.properties)
      .sample("cloud_ground", refs.weather.ground)
      .sample("cloud_tile", refs.weather.tile, Sampler::linear_repeat)
      .sample("cloud_field", refs.noise.field, Sampler::linear_repeat)
      .sample("cloud_cells", refs.noise.cells, Sampler::linear_repeat)
      .sample("cloud_shape", refs.noise.shape, Sampler::linear_repeat)
      .sample("cloud_detail", refs.noise.detail, Sampler::linear_repeat)
      .sample("cloud_turbulence", refs.noise.turbulence, Sampler::linear_repeat);
}

}  // namespace nepho
