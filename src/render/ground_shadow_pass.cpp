#include "render/ground_shadow_pass.h"

#include "gpu/commands.h"
#include "render/ground_shadow.comp.h"
#include "render/shadow_layers.comp.h"

namespace nepho {

GroundShadowPass::GroundShadowPass(gpu::Device& device)
    : device_(device), pipeline_(device, {.name = "ground_shadow", .spirv = ground_shadow_comp}) {}

ImageRef GroundShadowPass::add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
                               const CloudShadowRefs& shadow) const {
  const ImageRef out = graph.create("sun_visibility", {.extent = frame.extent, .format = Format::r32f});
  auto pass = graph.pass("ground_shadow");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", terrain.depth_m, Sampler::nearest_clamp)
      .read("pixel_tiles", terrain.surface_tiles)
      .indirect(terrain.surface_tiles)
      .write("sun_visibility", out);
  bind_cloud_shadow(pass, shadow);
  pass.record([this](gpu::Commands& cmd) { cmd.bind(pipeline_).dispatch_indirect(); });
  return out;
}

ImageRef GroundShadowPass::add_layers(FrameGraph& graph, const FrameInfo& frame, const Shown& shown,
                                      const CloudShadowRefs& shadow) const {
  if (!layers_) layers_ = gpu::ComputePipeline(device_, {.name = "shadow_layers", .spirv = shadow_layers_comp});
  const ImageRef out = graph.create("shadow_layers", {.extent = frame.extent, .format = Format::rg32f});
  auto pass = graph.pass("shadow_layers");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", shown.depth_m, Sampler::nearest_clamp)
      .sample("sun_visible_share", shown.visibility, Sampler::nearest_clamp)
      .sample("cloud_radiance", shown.cloud_radiance, Sampler::nearest_clamp)
      .sample("cloud_info", shown.cloud_info, Sampler::nearest_clamp)
      .write("shadow_layers", out);
  bind_cloud_shadow(pass, shadow);
  pass.record([this, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(layers_).dispatch_threads(extent.width, extent.height);
  });
  return out;
}

}  // namespace nepho
