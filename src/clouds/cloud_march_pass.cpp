#include "clouds/cloud_march_pass.h"

#include <algorithm>

#include "clouds/cloud_clear.comp.h"
#include "clouds/cloud_march.comp.h"
#include "clouds/cloud_shade.comp.h"
#include "gpu/commands.h"

namespace nepho {

namespace {
struct ShadePush {
  float ground_albedo, coverage, sky_light_scale, ground_bounce_scale;
  uint32_t traced;
};
/// Share of the sky that is covered, for the light that reaches the ground between clouds.
constexpr double kTypicalCoverage = 0.4;
/// From above, pixels wider than this hide so much of the clouds that the density's filter says too little.
constexpr double kWidePixel_m = 300.0;
}  // namespace

CloudMarchPass::CloudMarchPass(gpu::Device& device, const Clouds& clouds, uint32_t spectral_groups, bool fine)
    : device_(device),
      clouds_(clouds),
      spectral_groups_(spectral_groups),
      clear_(device, {.name = "clouds.clear", .spirv = cloud_clear_comp}),
      fine_(fine) {}

const gpu::ComputePipeline& CloudMarchPass::march_pipeline(uint32_t phases, bool terrain, bool rays, bool listed,
                                                           bool fine) const {
  gpu::ComputePipeline& pipeline =
      march_[phases - 1 + (terrain ? 2 : 0) + (rays ? 4 : 0) + (listed ? 8 : 0) + (fine ? 16 : 0)];
  if (!pipeline) {
    std::vector<uint32_t> constants = clouds_.specialisation(phases);
    constants.push_back(terrain ? 1 : 0);
    constants.push_back(fine ? 1 : 0);
    constants.push_back(rays ? 4 : 1);
    constants.push_back(listed ? 1 : 0);
    pipeline = gpu::ComputePipeline(
        device_, {.name = "clouds.march", .spirv = cloud_march_comp, .constants = std::move(constants)});
  }
  return pipeline;
}

const gpu::ComputePipeline& CloudMarchPass::shade_pipeline(bool listed, bool volume) const {
  gpu::ComputePipeline& pipeline = shade_[(listed ? 1u : 0u) + (volume ? 2u : 0u)];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(device_, {.name = "clouds.shade",
                                              .spirv = cloud_shade_comp,
                                              .constants = {spectral_groups_, listed ? 1u : 0u, volume ? 1u : 0u}});
  return pipeline;
}

CloudMarchPass::Marched CloudMarchPass::add_march(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) const {
  const CloudDensityRefs& density = in.density;
  const CloudLight::Refs& light = in.light;
  const bool listed = static_cast<bool>(in.list);
  const Marched out{
      .light = graph.create("clouds.light", {.extent = frame.extent, .format = Format::rgba32f}),
      .info = listed ? in.info : graph.create("clouds.info", {.extent = frame.extent, .format = Format::rgba32f}),
      .near = graph.create("clouds.light_near", {.extent = frame.extent, .format = Format::rgba32f}),
      .depths = listed ? in.depths : graph.create("clouds.depths", {.extent = frame.extent, .format = Format::rg32f})};
  FrameGraph::PassBuilder pass = graph.pass("clouds.march");
  pass.uniform("frame", frame.buffer)
      .read("depth_m", in.depth_m)
      .sample("cloud_blue", density.noise.blue, Sampler::nearest_clamp)
      .uniform("light_data", light.data)
      .sample("grid_tex", light.grid)
      .sample("most_tex", light.most, Sampler::nearest_clamp)
      .sample("cells_tex", light.cells)
      .sample("beam_tex", light.beam)
      .sample("terrain_volume_tex", light.terrain_shadow)
      .uniform("terrain_volume", light.terrain_map);
  bind_density(pass, density);
  bind_pixel_list(graph, pass, in.list, 64);
  const bool fine = fine_ && !in.whole_steps;
  double top_m = 0.0;
  for (const Clouds::HeightRange& r : clouds_.layer_ranges()) top_m = std::max(top_m, r.high_m);
  const double pixel_m = static_cast<double>(frame.constants.pixel_angle_rad) *
                         (static_cast<double>(frame.constants.planet.camera_height_m) - top_m);
  const gpu::ComputePipeline& pipeline =
      march_pipeline(clouds_.phases_at(frame.time_s), light.terrain, fine && pixel_m > kWidePixel_m, listed, fine);
  pass.write("out_light", out.light)
      .write("out_info", out.info)
      .write("out_near", out.near)
      .write("out_depths", out.depths)
      .record([&pipeline, listed, extent = frame.extent](gpu::Commands& cmd) {
        if (listed)
          cmd.bind(pipeline).dispatch_indirect();
        else
          cmd.bind(pipeline).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

CloudMarchPass::Outputs CloudMarchPass::add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) const {
  const bool listed = static_cast<bool>(in.list);
  const ImageRef radiance =
      listed ? in.radiance : graph.create("clouds.radiance", {.extent = frame.extent, .format = Format::rgba32f});
  const ImageRef near = graph.create("clouds.near", {.extent = frame.extent, .format = Format::rgba32f});
  const CloudParams& params = clouds_.params();
  if (draws_nothing(params)) {
    const ImageRef info = graph.create("clouds.info", {.extent = frame.extent, .format = Format::rgba32f});
    const ImageRef depths = graph.create("clouds.depths", {.extent = frame.extent, .format = Format::rg32f});
    graph.pass("clouds.clear")
        .write("out_radiance", radiance)
        .write("out_info", info)
        .write("out_near", near)
        .write("out_depths", depths)
        .record([this, extent = frame.extent](gpu::Commands& cmd) {
          cmd.bind(clear_).dispatch_threads(extent.width, extent.height);
        });
    return {.radiance = radiance, .info = info, .near = near, .depths = depths};
  }
  const Marched marched = add_march(graph, frame, in);
  FrameGraph::PassBuilder shade = graph.pass("clouds.shade");
  shade.uniform("frame", frame.buffer)
      .sample("light_tex", marched.light, Sampler::nearest_clamp)
      .sample("near_tex", marched.near, Sampler::nearest_clamp)
      .sample("depths_tex", marched.depths, Sampler::nearest_clamp)
      .write("out_radiance", radiance)
      .write("out_near", near);
  AtmosphereTables::bind(shade, in.atmosphere);
  AirVolume::bind(graph, shade, in.air_volume, in.atmosphere);
  bind_pixel_list(graph, shade, in.list, 256);
  const ShadePush push{kGroundAlbedo, static_cast<float>(params.coverage.value_or(kTypicalCoverage)),
                       static_cast<float>(params.sky_light_scale), static_cast<float>(params.ground_bounce_scale),
                       params.multiple_scattering == "octaves" ? 0u : 1u};
  const gpu::ComputePipeline& shader = shade_pipeline(listed, static_cast<bool>(in.air_volume));
  shade.record([&shader, push, listed, extent = frame.extent](gpu::Commands& cmd) {
    if (listed)
      cmd.bind(shader).push(push).dispatch_indirect();
    else
      cmd.bind(shader).push(push).dispatch_threads(extent.width, extent.height);
  });
  return {.radiance = radiance, .info = marched.info, .near = near, .depths = marched.depths};
}

}  // namespace nepho
