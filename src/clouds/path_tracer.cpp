#include "clouds/path_tracer.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "base/error.h"
#include "clouds/path_trace.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::PathResult) == 48);
static_assert(sizeof(shared::PathRay) == 32);
static_assert(sizeof(shared::PathPush) == 28);
static_assert(sizeof(shared::PathWork) == 28);
static_assert(sizeof(shared::PathLane) == 17 * 4 + 10 * 12);

struct SceneBlock {
  shared::CloudBounds bounds;
  shared::RegionMap ground;
};

/// Invocations that take paths from the counter: enough to fill a large GPU. A software device runs a few at a time,
/// for so many turns of their loop (its limit is 65536 of all loops together; a turn takes some 100).
constexpr uint32_t kThreadsOfGpu = 512 * 1024, kThreadsOfCpu = 2048, kTurnsOfCpu = 400;

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

uint32_t PathTracer::most_paths() const {
  // Software devices have storage buffers of 128 MiB; GPUs want long rounds, as the last paths of one leave most of it
  // idle.
  return ((device_.info().is_software ? 120u : 768u) << 20) / static_cast<uint32_t>(sizeof(shared::PathResult));
}

const gpu::ComputePipeline& PathTracer::pipeline(uint32_t phases) {
  gpu::ComputePipeline& wanted = trace_[phases - 1];
  if (!wanted) {
    std::vector<uint32_t> constants = clouds_.specialisation(phases);
    constants.resize(17, 0u);
    constants[0] = static_cast<uint32_t>(mode_);
    constants[16] = device_.info().is_software ? kTurnsOfCpu : 0u;
    wanted = gpu::ComputePipeline(device_, {.name = "paths.trace", .spirv = path_trace_comp, .constants = constants});
  }
  return wanted;
}

void PathTracer::run(gpu::GraphExecutor& executor, const FrameInfo& frame,
                     const std::function<Inputs(FrameGraph&, const FrameInfo&)>& make_inputs,
                     std::span<const uint32_t> samples, std::span<const uint32_t> first_samples,
                     shared::PathPush push) {
  std::vector<shared::PathPlan> plan(samples.size() + 1);
  uint32_t paths = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    plan[i] = {paths, first_samples[i]};
    paths += samples[i];
  }
  plan.back() = {paths, 0u};
  NEPHO_ASSERT(paths > 0 && paths <= most_paths());
  push.items = paths;
  push.pixels = static_cast<uint32_t>(samples.size());
  const bool software = device_.info().is_software;
  const uint32_t threads = std::min((paths + 63) / 64 * 64, software ? kThreadsOfCpu : kThreadsOfGpu);
  const auto hold = [&](gpu::Buffer& buffer, const char* name, uint64_t bytes) {
    if (!buffer || buffer.desc().size_bytes < bytes)
      buffer = device_.create_buffer({.name = name, .size_bytes = bytes});
  };
  hold(results_, "paths.results", uint64_t{paths} * sizeof(shared::PathResult));
  hold(work_, "paths.work", sizeof(shared::PathWork));
  hold(lanes_, "paths.lanes", uint64_t{software ? threads : 1} * sizeof(shared::PathLane));
  hold(plan_, "paths.plan", plan.size() * sizeof(shared::PathPlan));
  const gpu::BufferUpload upload_plan{&plan_, 0, std::as_bytes(std::span(plan))};
  device_.upload({}, {&upload_plan, 1});
  counts_ = {};
  trace_ms_ = 0.0;
  shared::PathWork work{};
  for (bool first = true; first || work.next < paths || work.unfinished > 0; first = false) {
    FrameGraph graph;
    FrameInfo here = frame;
    here.buffer = graph.constants("frame", here.constants);
    const Inputs in = make_inputs(graph, here);
    const BufferRef work_ref = graph.import(work_), lanes_ref = graph.import(lanes_);
    if (first) {
      graph.pass("paths.begin").zero("work", work_ref).zero("lanes", lanes_ref).effect().record([](gpu::Commands& cmd) {
        cmd.zero("work").zero("lanes");
      });
    } else {
      work.unfinished = 0;
      const gpu::BufferUpload upload{&work_, 0, std::as_bytes(std::span(&work, 1))};
      device_.upload({}, {&upload, 1});
    }
    const ImageRef none = graph.import(none_2d_), none_array = graph.import(none_array_);
    const auto or_none = [&](ImageRef image) { return image ? image : none; };
    auto pass = graph.pass("paths.trace");
    pass.uniform("frame", here.buffer)
        .uniform("scene", graph.constants("paths.scene", SceneBlock{in.bounds->data(), in.ground}))
        .sample("bounds_tex", graph.import(in.bounds->image()), Sampler::nearest_clamp)
        .sample("surface_depth", or_none(in.surface_depth), Sampler::nearest_clamp)
        .sample("surface_albedo", or_none(in.surface_albedo), Sampler::nearest_clamp)
        .sample("surface_normal", or_none(in.surface_normal), Sampler::nearest_clamp)
        .sample("key_tex", or_none(in.key))
        .sample("ground_albedo_tex", in.ground_albedo ? in.ground_albedo : none_array)
        .sample("ground_height_tex", in.ground_height ? in.ground_height : none_array)
        .read("rays", in.rays ? in.rays : graph.constants("paths.no_rays", shared::PathRay{}))
        .read("plan", graph.import(plan_))
        .read_write("work", work_ref)
        .read_write("lanes", lanes_ref)
        .write("results", graph.import(results_))
        .effect();
    bind_density(pass, in.density);
    pass.record([&program = pipeline(clouds_.phases_at(frame.time_s)), push, threads](gpu::Commands& cmd) {
      cmd.bind(program).push(push).dispatch_threads(threads);
    });
    executor.run(graph);
    for (const gpu::PassTiming& t : executor.timings())
      if (t.name == "paths.trace") trace_ms_ += t.gpu_ms;
    const std::vector<std::byte> bytes = device_.download(work_);
    std::memcpy(&work, bytes.data(), sizeof(work));
  }
  counts_ = work.counts;
}

}  // namespace nepho
