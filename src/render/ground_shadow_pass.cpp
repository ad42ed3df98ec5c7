#include "render/ground_shadow_pass.h"

#include "gpu/commands.h"
#include "render/ground_shadow.comp.h"

namespace nepho {

ImageRef GroundShadowPass::add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
                               const CloudDensityRefs& density) const {
  const ImageRef out = graph.create("sun_visibility", {.extent = frame.extent, .format = Format::r32f});
  auto pass = graph.pass("ground_shadow");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", terrain.depth_m, Sampler::nearest_clamp)
      .read("pixel_tiles", terrain.surface_tiles)
      .indirect(terrain.surface_tiles)
      .write("sun_visibility", out);
  bind_density(pass, density);
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = pipeline_[phases - 1];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(
        device_, {.name = "ground_shadow", .spirv = ground_shadow_comp, .constants = clouds_.specialisation(phases)});
  pass.record([&pipeline](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_indirect(); });
  return out;
}

}  // namespace nepho
