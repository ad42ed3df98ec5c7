#include "render/exposure_passes.h"

#include <cmath>

#include "base/error.h"
#include "gpu/commands.h"
#include "render/exposure_histogram.comp.h"
#include "render/exposure_reduce.comp.h"
#include "render/render_shared.h"
#include "render/tonemap.comp.h"
#include "tone/tone.h"
#include "tone/white_balance.h"

namespace nepho {

static_assert(sizeof(shared::ExposurePush) == 36);
static_assert(sizeof(shared::TonemapPush) == 48);

namespace {
/// Share of the last picture's EV100 that remains after this time.
float keep_share(double frame_interval_s, double adaptation_s) {
  if (!(frame_interval_s > 0.0) || !(adaptation_s > 0.0)) return 0.0f;
  return static_cast<float>(std::exp(-frame_interval_s / adaptation_s));
}
}  // namespace

ExposurePasses::ExposurePasses(gpu::Device& device)
    : device_(device),
      histogram_(device, {.name = "exposure.histogram", .spirv = exposure_histogram_comp}),
      reduce_(device, {.name = "exposure.reduce", .spirv = exposure_reduce_comp}),
      adapted_(device.create_buffer({.name = "exposure.adapted", .size_bytes = sizeof(shared::ExposureState)})) {
  const shared::ExposureState none{};
  const gpu::BufferUpload upload{.buffer = &adapted_, .bytes = std::as_bytes(std::span(&none, 1))};
  device.upload({}, {&upload, 1});
}

const gpu::ComputePipeline& ExposurePasses::tonemap_for(uint32_t curve) {
  const auto found = tonemap_.find(curve);
  if (found != tonemap_.end()) return found->second;
  return tonemap_
      .emplace(curve, gpu::ComputePipeline(device_, {.name = "tonemap", .spirv = tonemap_comp, .constants = {curve}}))
      .first->second;
}

ExposurePasses::Outputs ExposurePasses::add(FrameGraph& graph, ImageRef radiance, const RenderParams& params,
                                            double frame_interval_s) {
  const Extent3D e = graph.desc(radiance).extent;
  const Extent2D extent{e.width, e.height};
  shared::ExposurePush push{};
  push.size = glm::uvec2(extent.width, extent.height);
  push.stride = shared::meter_stride(extent.width, extent.height);
  push.automatic = params.exposure_ev100 ? 0u : 1u;
  push.fixed_ev100 = static_cast<float>(params.exposure_ev100.value_or(0.0));
  push.min_ev100 = static_cast<float>(params.min_ev100);
  push.max_ev100 = static_cast<float>(params.max_ev100);
  push.compensation_ev = static_cast<float>(params.exposure_compensation_ev);
  push.keep_share = keep_share(frame_interval_s, params.exposure_adaptation_s);

  // Zeroed by its upload: the histogram adds to what is there.
  const BufferRef bins = graph.constants("exposure.bins", std::vector<uint32_t>(shared::kHistogramBins, 0u));
  const Outputs out{.display = graph.create("display", {.extent = extent, .format = Format::rgba8}),
                    .state = graph.create_buffer("exposure.state", sizeof(shared::ExposureState))};
  graph.pass("exposure.histogram")
      .sample("radiance", radiance, Sampler::nearest_clamp)
      .read_write("histogram", bins)
      .record([this, extent, push](gpu::Commands& cmd) {
        cmd.bind(histogram_).push(push).dispatch_threads(extent.width / push.stride, extent.height / push.stride);
      });
  graph.pass("exposure.reduce")
      .read("histogram", bins)
      .write("exposure", out.state)
      .read_write("adapted", graph.import(adapted_))
      .record(
          [this, push](gpu::Commands& cmd) { cmd.bind(reduce_).push(push).dispatch_threads(shared::kHistogramBins); });
  const gpu::ComputePipeline& tonemap = tonemap_for(tone_curve_id(params.tone_curve));
  const shared::TonemapPush tone{glm::uvec2(extent.width, extent.height), params.seed * 0x9e3779b9u,
                                 glm::mat3(rec709_white_balance(params.white_balance_k))};
  graph.pass("tonemap")
      .sample("radiance", radiance, Sampler::nearest_clamp)
      .uniform("exposure", out.state)
      .write("display", out.display)
      .record([&tonemap, extent, tone](gpu::Commands& cmd) {
        cmd.bind(tonemap).push(tone).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
