// Pictures of quality reference: paths until the noise is low enough (docs/reference.md).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "atmosphere/sky_view.h"
#include "base/error.h"
#include "render/output_layers.h"
#include "render/reference_sums.h"
#include "render/renderer_parts.h"

namespace nepho {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Without a limit of their own, pictures of a given noise end here.
constexpr uint32_t kMostPaths = 1u << 24;
constexpr uint32_t kFirstCheck = 16;
/// Paths a pixel at which the noise is looked at: fixed numbers, so that the same scene gives the same picture however
/// fast the machine is.
uint32_t next_check(uint32_t paths) {
  return paths < kFirstCheck ? kFirstCheck : static_cast<uint32_t>(std::ceil(1.2 * static_cast<double>(paths)));
}

/// A dispatch should take about so long: interrupts are quick, and no watchdog barks.
constexpr double kDispatch_s = 0.7;

}  // namespace

RenderResult Renderer::render_reference(const RenderRequest& request) {
  Parts& p = *parts_;
  ReferenceTracer& tracer = *p.reference;
  const RenderParams& params = scene_.render;
  const Extent2D extent{params.width, params.height};
  const uint32_t along = ReferenceTracer::subpixels_of(extent);
  RenderResult result;
  result.pose = p.pose;
  timings_.frame_ms = timings_.readback_ms = timings_.terrain_ms = 0.0;
  FrameReadback readback;
  readback.extent = extent;

  // What is behind the clouds: of every sub-pixel for the paths, of the pixels' centres for the layers.
  for (const uint32_t finer : {1u, along}) {
    const Extent2D size{extent.width * finer, extent.height * finer};
    FrameGraph graph;
    FrameInfo frame;
    frame.extent = size;
    frame.camera_ecef_m = p.pose.ecef_m;
    frame.time_s = p.time_s;
    frame.constants = make_frame_constants(p.pose, size, p.light, p.time_s, 0, params.seed, glm::vec2(0.0f));
    frame.constants.night_illuminance =
        shared::night_sky_illuminance(static_cast<float>(scene_.night_sky.airglow_cd_m2), scene_.night_sky.stars);
    frame.buffer = graph.constants("frame", frame.constants);
    const auto start = Clock::now();
    p.terrain.prepare(frame);
    timings_.terrain_ms += 1e3 * seconds_since(start);
    const std::vector<shared::SkyView> views = sky_views_of(p.atmosphere->uniform(), frame.constants);
    const AtmosphereTables::Refs atmosphere = p.atmosphere->add(graph, views);
    const NightSky::Refs night_sky = p.night_sky.add(graph, frame, scene_.night_sky, p.sky);
    const Terrain::Outputs terrain = p.terrain.add(graph, frame);
    const ImageRef background =
        p.background.add(graph, frame, scene_.atmosphere,
                         {.terrain = terrain,
                          .atmosphere = atmosphere,
                          .night_sky = night_sky,
                          .has_sky_view = !views.empty(),
                          .night = NightSky::shows(frame.constants) || frame.constants.light_count > 1,
                          .sun_visibility = {}});
    const bool centres = finer == 1u;
    if (centres) {
      graph.keep(terrain.depth_m);
      graph.keep(terrain.albedo);
      graph.keep(background);
    }
    if (finer == along) tracer.add_surface(graph, frame, {terrain, background}, atmosphere);
    p.executor.run(graph);
    timings_.passes = p.executor.timings();
    if (centres) {
      readback.depth_m = p.executor.read<float>(terrain.depth_m);
      readback.albedo.clear();
      for (const uint16_t half : p.executor.read<uint16_t>(terrain.albedo))
        readback.albedo.push_back(glm::unpackHalf1x16(half));
      readback.background = p.executor.read<float>(background);
    }
    if (finer == along) {
      tracer.begin(frame, extent, p.terrain);
      break;
    }
  }

  std::vector<shared::PixelSums> earlier;
  uint32_t first = 0;
  if (request.resume) {
    earlier = sums_of_picture(*request.resume, extent);
    first = static_cast<uint32_t>(earlier.front().paths);
  }
  // A number of paths, or paths until the noise is low enough, but no more than that number where it is given too.
  const bool by_noise = params.noise > 0.0;
  const uint32_t most = by_noise && params.frames <= 1 ? kMostPaths : params.frames;
  const auto start = Clock::now();
  uint32_t done = first, check = first;
  while (check <= done) check = next_check(check);
  uint32_t batch = 1;
  ReferenceProgress& at = result.reference;
  at.paths = first;
  at.noise = earlier.empty() ? 1.0 : noise_of(earlier);
  std::vector<shared::PixelSums> sums = earlier;
  while (done < most && !(by_noise && at.noise <= params.noise)) {
    const uint32_t now = std::min({batch, check - done, most - done});
    const auto begun = Clock::now();
    tracer.trace(p.executor, *p.atmosphere, done, now);
    const double took_s = seconds_since(begun);
    batch = static_cast<uint32_t>(
        std::clamp(static_cast<double>(now) * kDispatch_s / std::max(took_s, 1e-4), 1.0, 4.0 * batch));
    done += now;
    if (done == check || done == most) {
      sums = earlier.empty() ? tracer.sums() : merged(earlier, tracer.sums());
      at.noise = noise_of(sums);
      check = next_check(done);
    }
    at.paths = done;
    at.elapsed_s = seconds_since(start);
    // Noise falls with the root of the number of paths.
    double wanted = static_cast<double>(most);
    if (by_noise && done >= kFirstCheck) {
      const double by_law = static_cast<double>(done) * std::pow(at.noise / params.noise, 2.0);
      wanted = std::min(wanted, std::max(by_law, static_cast<double>(done)));
    }
    at.fraction = static_cast<double>(done) / wanted;
    at.left_s = (wanted - done) * at.elapsed_s / std::max<double>(done - first, 1.0);
    if (request.on_progress && !request.on_progress(at)) {
      result.interrupted = done < most && !(by_noise && at.noise <= params.noise);
      break;
    }
  }
  sums = earlier.empty() ? tracer.sums() : done > first ? merged(earlier, tracer.sums()) : earlier;
  at.noise = noise_of(sums);
  timings_.frame_ms = 1e3 * seconds_since(start);
  timings_.reference = tracer.counts();
  timings_.reference.noise = at.noise;

  const auto reading = Clock::now();
  put_sums(sums, readback);
  if (request.display) {
    FrameGraph tone;
    const gpu::Image image = device_.create_image({.name = "mean", .extent = extent, .format = Format::rgba32f});
    const gpu::ImageUpload upload{&image, std::as_bytes(std::span(readback.radiance))};
    device_.upload({&upload, 1});
    const ExposurePasses::Outputs out = p.exposure.add(tone, tone.import(image), params, request.frame_interval_s);
    tone.keep(out.display);
    tone.keep(out.state);
    p.executor.run(tone);
    const std::vector<uint8_t> rgba = p.executor.read<uint8_t>(out.display);
    const size_t pixels = size_t{extent.width} * extent.height;
    result.display_rgb.resize(3 * pixels);
    for (size_t k = 0; k < pixels; ++k) std::memcpy(&result.display_rgb[3 * k], &rgba[4 * k], 3);
    result.ev100 = static_cast<double>(p.executor.read<float>(out.state)[0]);
  }
  if (request.layers) result.layers = make_output_layers(readback, p.pose, request.wanted);
  timings_.readback_ms = 1e3 * seconds_since(reading);
  timings_.gpu_memory_bytes = device_.memory_bytes();
  return result;
}

}  // namespace nepho
