#include "render/terrain_shadow_pass.h"

#include "gpu/commands.h"
#include "render/terrain_shadow.comp.h"

namespace nepho {

ImageRef TerrainShadowPass::add(FrameGraph& graph, const FrameInfo& frame, const Terrain::Outputs& terrain,
                                const TerrainShadowMap::Refs& shadow, ImageRef lit, ImageRef cloud_share) const {
  const uint32_t clouds = cloud_share ? 1u : 0u;
  gpu::ComputePipeline& pipeline = pipelines_[clouds];
  if (!pipeline)
    pipeline =
        gpu::ComputePipeline(device_, {.name = "terrain_shadow", .spirv = terrain_shadow_comp, .constants = {clouds}});
  const ImageRef out = graph.create("sun_visibility.terrain", {.extent = frame.extent, .format = Format::r32f});
  auto pass = graph.pass("terrain_shadow");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", terrain.depth_m, Sampler::nearest_clamp)
      .sample("cloud_share", cloud_share ? cloud_share : terrain.depth_m, Sampler::nearest_clamp)
      .sample("terrain_lit_tex", lit, Sampler::nearest_clamp)
      .read("pixel_tiles", terrain.surface_tiles)
      .indirect(terrain.surface_tiles)
      .write("sun_visibility", out);
  bind_terrain_shadow(pass, shadow);
  pass.record([&pipeline](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_indirect(); });
  return out;
}

}  // namespace nepho
