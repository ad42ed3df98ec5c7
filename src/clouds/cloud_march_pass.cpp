#include "clouds/cloud_march_pass.h"

#include "clouds/cloud_clear.comp.h"
#include "clouds/cloud_march.comp.h"
#include "clouds/cloud_shade.comp.h"
#include "gpu/commands.h"

namespace nepho {

namespace {
struct ShadePush {
  float ground_albedo, coverage;
};
}  // namespace

CloudMarchPass::CloudMarchPass(gpu::Device& device, uint32_t spectral_groups)
    : march_(device, {.name = "clouds.march", .spirv = cloud_march_comp}),
      shade_(device, {.name = "clouds.shade", .spirv = cloud_shade_comp, .constants = {spectral_groups}}),
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
  const ImageRef light = graph.create("clouds.light", {.extent = frame.extent, .format = Format::rgba32f});
  FrameGraph::PassBuilder march = graph.pass("clouds.march");
  march.uniform("frame", frame.buffer).read("depth_m", in.depth_m);
  bind_density(march, in.density);
  march.write("out_light", light).write("out_info", out.info).record([this, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(march_).dispatch_threads(extent.width, extent.height);
  });
  FrameGraph::PassBuilder shade = graph.pass("clouds.shade");
  shade.uniform("frame", frame.buffer)
      .sample("light_tex", light, Sampler::nearest_clamp)
      .sample("info_tex", out.info, Sampler::nearest_clamp)
      .write("out_radiance", out.radiance);
  AtmosphereTables::bind(shade, in.atmosphere);
  const ShadePush push{kGroundAlbedo, static_cast<float>(params.coverage)};
  shade.record([this, push, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(shade_).push(push).dispatch_threads(extent.width, extent.height);
  });
  return out;
}

}  // namespace nepho
