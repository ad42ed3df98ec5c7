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
#include "render/sample_plan.h"

namespace nepho {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Paths of every pixel that tell whether a pilot is worth it, and the largest pilot.
constexpr double kPilot = 64.0, kMostPilot = 512.0;
/// Below so many paths a pixel it is not.
constexpr double kPilotFrom = 1024.0;

/// A round should take about so long: interrupts are quick, and no watchdog barks.
constexpr double kRound_s = 1.5;
/// Paths of a round at least: fewer would wait for the longest of them.
constexpr double kLeastRound = 30e3;

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
    // Paths know one light with shadows and no other: deep at night that is all of the moon's.
    if (frame.constants.key_dir == frame.constants.moon_dir)
      frame.constants.key_illuminance = frame.constants.moon_share * frame.constants.sun_illuminance_1au;
    frame.constants.night_illuminance =
        shared::night_sky_illuminance(static_cast<float>(scene_.night_sky.airglow_cd_m2), scene_.night_sky.stars);
    frame.buffer = graph.constants("frame", frame.constants);
    const auto start = Clock::now();
    p.terrain.prepare(
        frame,
        {.complete = !request.incomplete_ok, .at_most_s = request.ground_wait_s, .on_progress = request.on_ground});
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
                          .sun_visibility = {},
                          .wind_mps = static_cast<float>(scene_.terrain.water_wind_mps)});
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

  const size_t pixels = size_t{extent.width} * extent.height;
  const bool by_noise = params.noise > 0.0;
  const double most = by_noise && params.frames <= 1 ? 1e9 : params.frames;  // paths a pixel
  std::vector<shared::PixelSums> earlier;
  if (request.resume) earlier = sums_of_picture(*request.resume, extent);
  SamplePlan plan = earlier.empty() ? SamplePlan::even(pixels) : SamplePlan::like(earlier);
  // Sample numbers that are taken: of an even picture those below its level, of another one's also a pilot's (no more
  // than the largest).
  std::vector<uint32_t> taken(pixels, 0), samples, numbers(pixels);
  double level = 0.0;
  for (size_t i = 0; i < earlier.size(); ++i) taken[i] = plan.is_even() ? 0 : static_cast<uint32_t>(kMostPilot);
  if (!earlier.empty()) level = plan.is_even() ? static_cast<double>(earlier.front().paths) : 1.0;

  const auto start = Clock::now();
  ReferenceProgress& at = result.reference;
  at.noise = earlier.empty() ? 1.0 : noise_of(earlier);
  std::vector<shared::PixelSums> sums = earlier;
  double check = plan.next_check(level), paths_per_s = 1e5;
  uint64_t fresh = 0;  // paths so far
  const auto mean_paths = [&](double l) { return static_cast<double>(plan.paths(l)) / static_cast<double>(pixels); };
  bool wants_more = true, even_for_good = false;
  double pilot = kPilot;
  while (mean_paths(level) < most && !(by_noise && at.noise <= params.noise) && wants_more) {
    double goal = check;
    if (plan.is_even()) goal = std::min(goal, most);
    const auto fits = static_cast<uint64_t>(std::max(paths_per_s * kRound_s, kLeastRound));
    const double reached = plan.round(
        level, goal, std::min<uint64_t>(fits, tracer.most_paths()),
        device_.info().is_software ? ReferenceTracer::kMostSamples : 8 * ReferenceTracer::kMostSamples, samples);
    for (size_t i = 0; i < pixels; ++i) numbers[i] = taken[i] + plan.at(i, level);
    const auto begun = Clock::now();
    const uint64_t now = plan.paths(reached) - plan.paths(level);
    if (now > 0) tracer.trace(p.executor, *p.atmosphere, samples, numbers);
    fresh += now;
    paths_per_s = std::clamp(static_cast<double>(now) / std::max(seconds_since(begun), 1e-4), 0.25 * paths_per_s,
                             8.0 * paths_per_s);
    level = reached;
    if (level >= goal) {
      sums = earlier.empty() ? tracer.sums() : merged(earlier, tracer.sums());
      at.noise = noise_of(sums);
      check = plan.next_check(level);
      if (by_noise && earlier.empty() && plan.is_even() && !even_for_good) {
        const double needed = level * std::pow(at.noise / params.noise, 2.0);
        if (level < kPilot) {
          pilot = check = kPilot;
        } else if (needed < kPilotFrom || most < needed) {
          even_for_good = true;
        } else if (level < pilot || pilot == kPilot) {
          // About a twentieth of the work.
          pilot = std::max(level, std::min(kMostPilot, std::exp2(std::floor(std::log2(needed / 20.0)))));
          check = pilot;
        }
        if (!even_for_good && level >= kPilot && level >= pilot) {
          plan = SamplePlan::by_need(sums, extent, params.noise);
          std::fill(taken.begin(), taken.end(), static_cast<uint32_t>(level));
          level = 0.0;
          check = plan.next_check(level);
          tracer.clear();
        }
      }
    }
    at.paths = mean_paths(level);
    at.elapsed_s = seconds_since(start);
    // Noise falls with the root of the number of paths.
    double wanted = most < 1e9 ? most : plan.is_even() ? std::max(kPilot, level) : mean_paths(1.0);
    if (by_noise && at.noise < 1.0 && level > 0.0)
      wanted = std::min(most, std::max(at.paths * std::pow(at.noise / params.noise, 2.0), at.paths));
    at.fraction = at.paths / std::max(wanted, 1.0);
    at.left_s = std::max(wanted - at.paths, 0.0) * static_cast<double>(pixels) * at.elapsed_s /
                std::max(static_cast<double>(fresh), 1.0);
    if (request.on_progress) wants_more = request.on_progress(at);
  }
  result.interrupted = !wants_more && mean_paths(level) < most && !(by_noise && at.noise <= params.noise);
  sums = earlier.empty() ? tracer.sums() : fresh > 0 ? merged(earlier, tracer.sums()) : earlier;
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
