#include "render/background_pass.h"

#include "gpu/commands.h"
#include "render/background.comp.h"
#include "render/composite.comp.h"
#include "render/render_shared.h"

namespace nepho {

static_assert(sizeof(shared::BackgroundPush) == 16);

namespace {
constexpr float kWind_mps = 6.0f;          // a moderate breeze over the sea, the ocean's mean
constexpr float kNightLight_cd_m2 = 8.0f;  // city centres seen from above (VIIRS: some 1e-7 W/cm2/sr, about that)
}  // namespace

BackgroundPass::BackgroundPass(gpu::Device& device, uint32_t spectral_groups)
    : device_(device), spectral_groups_(spectral_groups) {}

const gpu::ComputePipeline& BackgroundPass::pipeline(bool surfaces, bool night) const {
  gpu::ComputePipeline& wanted = pipelines_[(surfaces ? 2u : 0u) + (night ? 1u : 0u)];
  if (!wanted)
    wanted = gpu::ComputePipeline(device_, {.name = "background",
                                            .spirv = background_comp,
                                            .constants = {spectral_groups_, surfaces ? 1u : 0u, night ? 1u : 0u}});
  return wanted;
}

ImageRef BackgroundPass::add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereParams& params,
                             const Inputs& in) const {
  const ImageRef out = graph.create("background", {.extent = frame.extent, .format = Format::rgba32f});
  const bool surfaces = static_cast<bool>(in.terrain.depth_m);
  const shared::BackgroundPush push{kWind_mps, in.terrain.emission ? kNightLight_cd_m2 : 0.0f,
                                    in.sun_visibility ? 1u : 0u, static_cast<float>(params.ground_albedo)};
  const ImageRef unused = in.atmosphere.transmittance;  // bound where a frame has nothing, and not read
  const auto or_unused = [&](ImageRef image) { return image ? image : unused; };
  auto pass = graph.pass("background");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", or_unused(in.terrain.depth_m), Sampler::nearest_clamp)
      .sample("albedo", or_unused(in.terrain.albedo), Sampler::nearest_clamp)
      .sample("normal", or_unused(in.terrain.normal), Sampler::nearest_clamp)
      .sample("emission", or_unused(in.terrain.emission ? in.terrain.emission : in.terrain.albedo),
              Sampler::nearest_clamp)
      .sample("sun_visible_share", or_unused(in.sun_visibility), Sampler::nearest_clamp)
      .write("background", out);
  AtmosphereTables::bind(pass, in.atmosphere);
  NightSky::bind(pass, in.night_sky);
  pass.record([this, push, surfaces, night = in.night, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(pipeline(surfaces, night)).push(push).dispatch_threads(extent.width, extent.height);
  });
  return out;
}

CompositePass::CompositePass(gpu::Device& device) : pipeline_(device, {.name = "composite", .spirv = composite_comp}) {}

ImageRef CompositePass::add(FrameGraph& graph, const FrameInfo& frame, ImageRef background,
                            ImageRef cloud_radiance) const {
  const ImageRef out = graph.create("radiance", {.extent = frame.extent, .format = Format::rgba32f});
  graph.pass("composite")
      .sample("background", background, Sampler::nearest_clamp)
      .sample("cloud_radiance", cloud_radiance, Sampler::nearest_clamp)
      .write("radiance", out)
      .record([this, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(pipeline_).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
