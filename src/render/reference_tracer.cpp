#include "render/reference_tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/log.h"
#include "gpu/commands.h"
#include "render/background_pass.h"
#include "render/reference_copy.comp.h"
#include "render/reference_key.comp.h"
#include "render/reference_shade.comp.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::PixelSums) == 68);
static_assert(sizeof(shared::ReferencePush) == 24);

constexpr uint64_t kMostBytes = 128u << 20;    ///< of a storage buffer
constexpr uint64_t kMostSubpixels = 2u << 20;  ///< of all pixels, about
constexpr uint32_t kMostSubpixelsAlong = 4;

PathTracer::Mode mode_of(const RenderParams& render) {
  return render.furnace_cd_m2 > 0.0 ? PathTracer::Mode::furnace : PathTracer::Mode::picture;
}

/// A frame's constants for another graph than the one that it was made with.
FrameInfo in_graph(const FrameInfo& frame, FrameGraph& graph) {
  FrameInfo copy = frame;
  copy.buffer = graph.constants("frame", copy.constants);
  return copy;
}

/// Which of the artist's options are not at their physical values, as they are named in a scene.
std::string artistic(const CloudParams& clouds) {
  std::string names;
  const auto add = [&names](const char* name) { names += fmt::format("{}clouds.{}", names.empty() ? "" : ", ", name); };
  if (clouds.multiple_scattering_weight != 1.0) add("multiple_scattering_weight");
  if (clouds.powder != 0.0) add("powder");
  return names;
}

}  // namespace

ReferenceTracer::ReferenceTracer(gpu::Device& device, const Scene& scene, const Clouds& clouds,
                                 uint32_t spectral_groups)
    : device_(device),
      clouds_(clouds),
      render_(scene.render),
      wind_mps_(static_cast<float>(scene.terrain.water_wind_mps)),
      bounds_(device, clouds),
      tracer_(device, clouds, mode_of(scene.render)),
      ground_(device),
      copy_(device, {.name = "reference.copy", .spirv = reference_copy_comp}),
      key_pipeline_(device, {.name = "reference.key", .spirv = reference_key_comp, .constants = {spectral_groups}}),
      shade_(device, {.name = "reference.shade",
                      .spirv = reference_shade_comp,
                      .constants = {spectral_groups, scene.render.furnace_cd_m2 > 0.0 ? 1u : 0u}}) {
  if (const std::string options = artistic(scene.clouds); !options.empty())
    log_warning("quality reference ignores artist's options: {}", options);
}

uint32_t ReferenceTracer::subpixels_of(Extent2D picture) {
  const uint64_t pixels = uint64_t{picture.width} * picture.height;
  uint32_t along = kMostSubpixelsAlong;
  while (along > 1 && pixels * along * along > kMostSubpixels) --along;
  return along;
}

void ReferenceTracer::check_size(Extent2D picture) {
  const uint64_t most = kMostBytes / sizeof(shared::PixelSums);
  if (uint64_t{picture.width} * picture.height > most)
    throw fail(ErrorKind::usage, "--size: {}x{} is too large for quality reference; at most {} pixels", picture.width,
               picture.height, most);
}

void ReferenceTracer::add_surface(FrameGraph& graph, const FrameInfo& frame, const Surface& surface,
                                  const AtmosphereTables::Refs& atmosphere) {
  const auto make = [&](const char* name, Extent3D extent, Format format) {
    return device_.create_image({.name = name, .extent = extent, .format = format});
  };
  depth_ = make("reference.depth_m", frame.extent, Format::r32f);
  albedo_ = make("reference.albedo", frame.extent, Format::rgba16f);
  normal_ = make("reference.normal", frame.extent, Format::rgba16f);
  emission_ = make("reference.emission", frame.extent, Format::rgba16f);
  background_ = make("reference.background", frame.extent, Format::rgba32f);
  key_ = make("reference.key", {shared::kKeyWidth, shared::kKeyHeight}, Format::rgba32f);
  has_emission_ = static_cast<bool>(surface.terrain.emission);
  graph.pass("reference.copy")
      .sample("depth_m", surface.terrain.depth_m, Sampler::nearest_clamp)
      .sample("albedo", surface.terrain.albedo, Sampler::nearest_clamp)
      .sample("normal", surface.terrain.normal, Sampler::nearest_clamp)
      .sample("emission", has_emission_ ? surface.terrain.emission : surface.terrain.albedo, Sampler::nearest_clamp)
      .sample("background", surface.background, Sampler::nearest_clamp)
      .write("out_depth_m", graph.import(depth_))
      .write("out_albedo", graph.import(albedo_))
      .write("out_normal", graph.import(normal_))
      .write("out_emission", graph.import(emission_))
      .write("out_background", graph.import(background_))
      .effect()
      .record([this, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(copy_).dispatch_threads(extent.width, extent.height);
      });
  auto key = graph.pass("reference.key");
  key.uniform("frame", frame.buffer).write("out_key", graph.import(key_)).effect();
  AtmosphereTables::bind(key, atmosphere);
  key.record(
      [this](gpu::Commands& cmd) { cmd.bind(key_pipeline_).dispatch_threads(shared::kKeyWidth, shared::kKeyHeight); });
  const double top_m = static_cast<double>(clouds_.constants().hull_high_m);
  bounds_.add(graph, frame, import_cloud_density(graph, frame, clouds_),
              cloud_region(frame.constants, frame.camera_ecef_m, top_m));
}

void ReferenceTracer::begin(const FrameInfo& frame, Extent2D picture, const Terrain& terrain) {
  frame_ = frame;
  picture_ = picture;
  subpixels_ = frame.extent.width / picture.width;
  counts_ = {};
  // As wide as a map of the clouds: ten kilometres of finest texels, to the far side of the Earth.
  shared::RegionMap map = bounds_.data().map;
  map.levels = std::max(map.levels, 1u);
  ground_.update(terrain.heights(), terrain.imagery(), map);
  const uint64_t bytes = uint64_t{picture.width} * picture.height * sizeof(shared::PixelSums);
  sums_ = device_.create_buffer({.name = "reference.sums", .size_bytes = bytes});
  clear();
}

void ReferenceTracer::clear() {
  const std::vector<std::byte> zeros(sums_.desc().size_bytes, std::byte{0});
  const gpu::BufferUpload upload{&sums_, 0, zeros};
  device_.upload({}, {&upload, 1});
}

void ReferenceTracer::trace(gpu::GraphExecutor& executor, const AtmosphereTables& atmosphere,
                            std::span<const uint32_t> samples, std::span<const uint32_t> first_samples) {
  const auto inputs = [this](FrameGraph& graph, const FrameInfo& frame) {
    const GroundMap::Refs ground = ground_.import_into(graph);
    return PathTracer::Inputs{.density = import_cloud_density(graph, frame, clouds_),
                              .bounds = &bounds_,
                              .ground = ground_.map(),
                              .ground_albedo = ground.albedo,
                              .ground_height = ground.height_m,
                              .surface_depth = graph.import(depth_),
                              .surface_albedo = graph.import(albedo_),
                              .surface_normal = graph.import(normal_),
                              .key = graph.import(key_),
                              .rays = {}};
  };
  tracer_.run(executor, frame_, inputs, samples, first_samples,
              {.items = 0,
               .pixels = 0,
               .seed = render_.seed,
               .width = picture_.width,
               .subpixels = subpixels_,
               .ground_albedo_scale = 1.0f,
               .wind_mps = wind_mps_});
  const auto pixels = static_cast<uint32_t>(samples.size());
  const shared::ReferencePush shade{.pixels = pixels,
                                    .seed = render_.seed,
                                    .width = picture_.width,
                                    .subpixels = subpixels_,
                                    .furnace_cd_m2 = static_cast<float>(render_.furnace_cd_m2),
                                    .night_light_cd_m2 = has_emission_ ? kNightLight_cd_m2 : 0.0f};
  FrameGraph graph;
  const FrameInfo frame = in_graph(frame_, graph);
  auto pass = graph.pass("reference.shade");
  pass.uniform("frame", frame.buffer)
      .sample("surface_emission", graph.import(emission_), Sampler::nearest_clamp)
      .sample("background", graph.import(background_), Sampler::nearest_clamp)
      .read("results", graph.import(tracer_.results()))
      .read("plan", graph.import(tracer_.plan()))
      .read_write("sums", graph.import(sums_))
      .effect();
  AtmosphereTables::bind(pass, atmosphere.add(graph, {}));
  pass.record([this, shade, pixels](gpu::Commands& cmd) { cmd.bind(shade_).push(shade).dispatch_threads(pixels); });
  executor.run(graph);
  const shared::PathCounts& c = tracer_.counts();
  counts_.paths += c.paths;
  counts_.vertices += c.vertices;
  counts_.density_reads += c.density_reads;
  counts_.moves += c.moves;
  counts_.overruns += c.overruns;
  counts_.trace_ms += tracer_.trace_ms();
  for (const gpu::PassTiming& t : executor.timings())
    if (t.name == "reference.shade") counts_.shade_ms += t.gpu_ms;
}

std::vector<shared::PixelSums> ReferenceTracer::sums() const {
  const std::vector<std::byte> bytes = device_.download(sums_);
  std::vector<shared::PixelSums> sums(bytes.size() / sizeof(shared::PixelSums));
  std::memcpy(static_cast<void*>(sums.data()), bytes.data(), bytes.size());
  return sums;
}

std::vector<float> ReferenceTracer::background() const {
  const std::vector<std::byte> bytes = device_.download(background_);
  std::vector<float> fine(bytes.size() / sizeof(float));
  std::memcpy(fine.data(), bytes.data(), bytes.size());
  std::vector<float> mean(size_t{4} * picture_.width * picture_.height, 0.0f);
  const float share = 1.0f / static_cast<float>(subpixels_ * subpixels_);
  for (size_t y = 0; y < frame_.extent.height; ++y)
    for (size_t x = 0; x < frame_.extent.width; ++x)
      for (size_t c = 0; c < 4; ++c)
        mean[4 * ((y / subpixels_) * picture_.width + x / subpixels_) + c] +=
            share * fine[4 * (y * frame_.extent.width + x) + c];
  return mean;
}

}  // namespace nepho
