#include "render/debug_views.h"

#include <algorithm>

#include "base/error.h"
#include "gpu/commands.h"
#include "render/debug_shared.h"
#include "render/debug_view.comp.h"

namespace nepho {
namespace {

uint32_t view_number(const std::string& view) {
  const std::vector<std::string> names = known_debug_views();  // in the order of kDebug...
  const auto at = std::find(names.begin(), names.end(), view);
  if (at == names.end())
    throw fail(ErrorKind::usage, "debug view '{}': unknown; known: {}", view, fmt::join(names, ", "));
  return static_cast<uint32_t>(at - names.begin());
}

}  // namespace

std::vector<std::string> known_debug_views() { return {"weather", "density", "layers", "samples", "steps", "shadows"}; }

ImageRef DebugViewPass::add(FrameGraph& graph, const FrameInfo& frame, const std::string& view, ImageRef depth_m,
                            const CloudDensityRefs& density, const CloudMarchPass::Outputs& marched,
                            const CloudShadowRefs& shadow) const {
  const uint32_t number = view_number(view);
  if (!pipeline_)
    pipeline_ = gpu::ComputePipeline(
        device_, {.name = "debug.view", .spirv = debug_view_comp, .constants = clouds_.specialisation(2)});
  const ImageRef out = graph.create("debug.view", {.extent = frame.extent, .format = Format::rgba8});
  FrameGraph::PassBuilder pass = graph.pass("debug.view");
  pass.uniform("frame", frame.buffer)
      .sample("cloud_radiance", marched.radiance, Sampler::nearest_clamp)
      .sample("cloud_info", marched.info, Sampler::nearest_clamp)
      .sample("depth_m", depth_m, Sampler::nearest_clamp)
      .write("display", out);
  bind_density(pass, density);
  bind_cloud_shadow(pass, shadow);
  pass.record([this, number, extent = frame.extent](gpu::Commands& cmd) {
    cmd.bind(pipeline_).push(number).dispatch_threads(extent.width, extent.height);
  });
  return out;
}

std::array<uint8_t, 3> DebugViewPass::clear_color(const std::string& view) {
  const uint32_t number = view_number(view);
  const bool count = number == shared::kDebugSamples || number == shared::kDebugSteps;
  const glm::vec3 color = count ? shared::turbo(0.0f) : glm::vec3(0.0f);
  std::array<uint8_t, 3> out{};
  for (int i = 0; i < 3; ++i) out[static_cast<size_t>(i)] = static_cast<uint8_t>(color[i] * 255.0f + 0.5f);
  return out;
}

}  // namespace nepho
