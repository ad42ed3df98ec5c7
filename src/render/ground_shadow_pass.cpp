#include "render/ground_shadow_pass.h"

#include "gpu/commands.h"
#include "render/ground_shadow.comp.h"

namespace nepho {

GroundShadowPass::GroundShadowPass(gpu::Device& device)
    : pipeline_(device, {.name = "ground_shadow", .spirv = ground_shadow_comp}) {}

ImageRef GroundShadowPass::add(FrameGraph& graph, const FrameInfo& frame, ImageRef depth_m,
                               const CloudDensityRefs& density) const {
  const ImageRef out = graph.create("sun_visibility", {.extent = frame.extent, .format = Format::r32f});
  auto pass = graph.pass("ground_shadow");
  pass.uniform("frame", frame.buffer).sample("depth_m", depth_m, Sampler::nearest_clamp).write("sun_visibility", out);
  bind_density(pass, density);
  pass.record([this, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(pipeline_).dispatch_threads(extent.width, extent.height);
  });
  return out;
}

}  // namespace nepho
