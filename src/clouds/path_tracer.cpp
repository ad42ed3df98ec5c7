#include "clouds/path_tracer.h"

#include "base/error.h"
#include "clouds/path_trace.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::PathResult) == 48);
static_assert(sizeof(shared::PathRay) == 32);
static_assert(sizeof(shared::PathPush) == 36);
static_assert(sizeof(shared::PathCounts) == 20);

struct SceneBlock {
  shared::CloudBounds bounds;
  shared::RegionMap ground;
};

/// Invocations that take paths from the counter: enough to fill a large GPU; a software device runs a few at a time, and
/// the rest find nothing to do.
constexpr uint32_t kThreadsOfGpu = 512 * 1024, kThreadsOfCpu = 1024;

}  // namespace

PathTracer::PathTracer(gpu::Device& device, const Clouds& clouds, Mode mode)
    : device_(device),
      clouds_(clouds),
      mode_(mode),
      none_2d_(device.create_image({.name = "paths.none", .extent = {1, 1}, .format = Format::rgba32f})),
      none_array_(
          device.create_image({.name = "paths.none_array", .extent = {1, 1}, .format = Format::rgba32f, .layers = 2})) {
  const float black_land[] = {0.0f, 0.0f, 0.0f, 1.0f};  // as ground_map.glsl has it; its height is 0
  const auto texel = std::as_bytes(std::span(black_land));
  const gpu::ImageUpload uploads[] = {{&none_2d_, texel}, {&none_array_, texel, 0, 0}, {&none_array_, texel, 0, 1}};
  device.upload(uploads);
}

PathTracer::Outputs PathTracer::add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in,
                                    const shared::PathPush& push) const {
  const uint32_t paths = push.pixels * push.samples;
  NEPHO_ASSERT(paths <= kMostPaths);
  const Outputs out{.results = graph.create_buffer("paths.results", uint64_t{paths} * sizeof(shared::PathResult)),
                    .work = graph.create_buffer("paths.work", 4 + sizeof(shared::PathCounts))};
  graph.pass("paths.begin").zero("work", out.work).record([](gpu::Commands& cmd) { cmd.zero("work"); });
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = trace_[phases - 1];
  if (!pipeline) {
    std::vector<uint32_t> constants = clouds_.specialisation(phases);
    constants[0] = static_cast<uint32_t>(mode_);
    pipeline =
        gpu::ComputePipeline(device_, {.name = "paths.trace", .spirv = path_trace_comp, .constants = constants});
  }
  const ImageRef none = graph.import(none_2d_), none_array = graph.import(none_array_);
  const auto or_none = [&](ImageRef image) { return image ? image : none; };
  const SceneBlock scene{in.bounds->data(), in.ground};
  auto pass = graph.pass("paths.trace");
  pass.uniform("frame", frame.buffer)
      .uniform("scene", graph.constants("paths.scene", scene))
      .sample("bounds_tex", graph.import(in.bounds->image()), Sampler::nearest_clamp)
      .sample("surface_depth", or_none(in.surface_depth), Sampler::nearest_clamp)
      .sample("surface_albedo", or_none(in.surface_albedo), Sampler::nearest_clamp)
      .sample("surface_normal", or_none(in.surface_normal), Sampler::nearest_clamp)
      .sample("key_tex", or_none(in.key))
      .sample("ground_albedo_tex", in.ground_albedo ? in.ground_albedo : none_array)
      .sample("ground_height_tex", in.ground_height ? in.ground_height : none_array)
      .read("rays", in.rays ? in.rays : graph.constants("paths.no_rays", shared::PathRay{}))
      .read_write("work", out.work)
      .write("results", out.results);
  bind_density(pass, in.density);
  const uint32_t threads = std::min(paths, device_.info().is_software ? kThreadsOfCpu : kThreadsOfGpu);
  pass.record([&pipeline, push, threads](gpu::Commands& cmd) { cmd.bind(pipeline).push(push).dispatch_threads(threads); });
  return out;
}

}  // namespace nepho
