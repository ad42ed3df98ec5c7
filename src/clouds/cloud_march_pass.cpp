#include "clouds/cloud_march_pass.h"

#include "clouds/cloud_clear.comp.h"
#include "clouds/cloud_march.comp.h"
#include "gpu/commands.h"

namespace nepho {

CloudMarchPass::CloudMarchPass(gpu::Device& device, uint32_t spectral_groups)
    : march_(device, {.name = "clouds.march", .spirv = cloud_march_comp, .constants = {spectral_groups}}),
      clear_(device, {.name = "clouds.clear", .spirv = cloud_clear_comp}) {}

CloudMarchPass::Outputs CloudMarchPass::add(FrameGraph& graph, const FrameInfo& frame, const CloudParams& params,
                                            const Inputs& in) const {
  const Outputs out{.radiance = graph.create("clouds.radiance", {.extent = frame.extent, .format = Format::rgba32f}),
                    .info = graph.create("clouds.info", {.extent = frame.extent, .format = Format::rgba32f})};
  if (draws_nothing(params)) {
    graph.pass("clouds.clear")
        .write("out_radiance", out.radiance)
        .write("out_info", out.info)
        .record([this, extent = frame.extent](gpu::Commands& cmd) {
          cmd.bind(clear_).dispatch_threads(extent.width, extent.height);
        });
    return out;
  }
  FrameGraph::PassBuilder pass = graph.pass("clouds.march");
  pass.uniform("frame", frame.buffer).read("depth_m", in.depth_m);
  bind_density(pass, in.density);
  AtmosphereTables::bind(pass, in.atmosphere);
  pass.write("out_radiance", out.radiance)
      .write("out_info", out.info)
      .record([this, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(march_).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
