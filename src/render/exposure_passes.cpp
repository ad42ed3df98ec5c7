#include "render/exposure_passes.h"

#include "base/error.h"
#include "common/tonemap.h"
#include "gpu/commands.h"
#include "render/exposure_histogram.comp.h"
#include "render/exposure_reduce.comp.h"
#include "render/render_shared.h"
#include "render/tonemap.comp.h"
#include "render/white_balance.h"

namespace nepho {

static_assert(sizeof(shared::ExposurePush) == 24);
static_assert(sizeof(shared::TonemapPush) == 52);

namespace {
// Automatic exposure: from airglow to the sun on snow.
constexpr float kMinEv100 = -8.0f, kMaxEv100 = 17.0f;

uint32_t tone_curve(const std::string& name) {
  if (name == "linear") return shared::kToneLinear;
  if (name == "reinhard") return shared::kToneReinhard;
  if (name == "aces") return shared::kToneAces;
  if (name == "agx") return shared::kToneAgx;
  throw fail(ErrorKind::usage, "tone_curve: '{}' is not one of aces, agx, reinhard, linear", name);
}
}  // namespace

ExposurePasses::ExposurePasses(gpu::Device& device)
    : histogram_(device, {.name = "exposure.histogram", .spirv = exposure_histogram_comp}),
      reduce_(device, {.name = "exposure.reduce", .spirv = exposure_reduce_comp}),
      tonemap_(device, {.name = "tonemap", .spirv = tonemap_comp}) {}

ExposurePasses::Outputs ExposurePasses::add(FrameGraph& graph, ImageRef radiance, const RenderParams& params) const {
  const Extent3D e = graph.desc(radiance).extent;
  const Extent2D extent{e.width, e.height};
  shared::ExposurePush push{};
  push.size = glm::uvec2(extent.width, extent.height);
  push.automatic = params.exposure_ev100 ? 0u : 1u;
  push.fixed_ev100 = static_cast<float>(params.exposure_ev100.value_or(0.0));
  push.min_ev100 = kMinEv100;
  push.max_ev100 = kMaxEv100;

  // Zeroed by its upload: the histogram adds to what is there.
  const BufferRef bins = graph.constants("exposure.bins", std::vector<uint32_t>(shared::kHistogramBins, 0u));
  const Outputs out{.display = graph.create("display", {.extent = extent, .format = Format::rgba8}),
                    .state = graph.create_buffer("exposure.state", sizeof(shared::ExposureState))};
  graph.pass("exposure.histogram")
      .sample("radiance", radiance, Sampler::nearest_clamp)
      .read_write("histogram", bins)
      .record([this, extent, push](gpu::Commands& cmd) {
        cmd.bind(histogram_).push(push).dispatch_threads(extent.width, extent.height);
      });
  graph.pass("exposure.reduce")
      .read_write("histogram", bins)
      .write("exposure", out.state)
      .record([this, push](gpu::Commands& cmd) { cmd.bind(reduce_).push(push).dispatch_threads(1); });
  const shared::TonemapPush tone{glm::uvec2(extent.width, extent.height), tone_curve(params.tone_curve), params.seed,
                                 glm::mat3(rec709_white_balance(params.white_balance_k))};
  graph.pass("tonemap")
      .sample("radiance", radiance, Sampler::nearest_clamp)
      .read("exposure", out.state)
      .write("display", out.display)
      .record([this, extent, tone](gpu::Commands& cmd) {
        cmd.bind(tonemap_).push(tone).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
