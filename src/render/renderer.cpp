#include "render/renderer_parts.h"

#include <glm/gtc/packing.hpp>

#include <chrono>
#include <cmath>
#include <cstring>

#include "astro/sky_bodies.h"
#include "atmosphere/luminance.h"
#include "atmosphere/sky_view.h"
#include "base/error.h"
#include "render/output_layers.h"
#include "render/render_shared.h"

namespace nepho {

namespace {
using Clock = std::chrono::steady_clock;

/// Time that a frame gives to tables of changed parameters, about.
constexpr double kAtmosphereSlice_ms = 5.0;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::vector<float> floats_from_half(const std::vector<uint16_t>& halves) {
  std::vector<float> out(halves.size());
  for (size_t i = 0; i < halves.size(); ++i) out[i] = glm::unpackHalf1x16(halves[i]);
  return out;
}
}  // namespace

namespace {
/// Of live pictures on a CPU: texels along a side of a shadow map, at most.
constexpr uint32_t kLiveShadowTexels = 256;

/// The cheapest preset lights clouds by octaves.
CloudParams as_drawn(const Scene& scene) {
  CloudParams clouds = scene.clouds;
  if (scene.render.quality == "low") clouds.multiple_scattering = "octaves";
  return clouds;
}
}  // namespace

Renderer::Parts::CloudParts::CloudParts(gpu::Device& device, const CloudParams& params, const WeatherSources& sources,
                                        uint32_t spectral_groups, const std::string& quality)
    : clouds(device, params, sources),
      ground(device),
      march(device, clouds, spectral_groups, quality == "high" || quality == "ultra"),
      upscaler(device, clouds),
      shadow(device),
      debug(device, clouds),
      make_lighting_([this, &device, shadows = params.shadows, spectral_groups, quality](bool live) {
        const bool software = device.info().is_software;
        CloudShadowParams fitting = shadows;
        if (live && software) fitting.resolution = std::min(fitting.resolution, kLiveShadowTexels);
        return std::make_unique<CloudLighting>(
            CloudLighting{.inside = CloudLight(device, clouds, spectral_groups,
                                               live ? CloudLight::live_quality_of(quality, software)
                                                    : CloudLight::quality_of(quality)),
                          .shadows = CloudShadowMaps(device, clouds, fitting)});
      }) {}

Renderer::Parts::CloudLighting& Renderer::Parts::CloudParts::lighting(bool live) {
  std::unique_ptr<CloudLighting>& of = lightings_[live ? 1 : 0];
  if (!of) of = make_lighting_(live);
  return *of;
}

Renderer::Parts::Parts(gpu::Device& device, TerrainSources sources, const SkySources& sky_sources,
                       const WeatherSources& weather, const Scene& scene, RenderTimings& timings)
    : software(device.info().is_software),
      executor(device),
      terrain(device, std::move(sources), scene.terrain),
      terrain_shadow_map(device),
      terrain_shadow(device),
      night_sky(device, sky_sources),
      air_volume(device, static_cast<uint32_t>(spectral_groups(scene.atmosphere))),
      background(device, static_cast<uint32_t>(spectral_groups(scene.atmosphere))),
      composite(device),
      shafts(device, static_cast<uint32_t>(spectral_groups(scene.atmosphere))),
      exposure(device) {
  auto start = Clock::now();
  atmosphere = std::make_unique<AtmosphereTables>(device, scene.atmosphere);
  timings.atmosphere_ms = ms_since(start);
  timings.atmosphere_cached = atmosphere->came_from_cache();
  start = Clock::now();
  const bool reference_wanted = scene.render.quality == "reference";
  if (reference_wanted || !draws_nothing(scene.clouds))
    clouds = std::make_unique<CloudParts>(device, as_drawn(scene), weather, atmosphere->spectral_groups(),
                                          scene.render.quality);
  if (reference_wanted) {
    ReferenceTracer::check_size({scene.render.width, scene.render.height});
    reference = std::make_unique<ReferenceTracer>(device, scene, clouds->clouds, atmosphere->spectral_groups());
  }
  timings.clouds_ms = ms_since(start);
}

std::vector<shared::SkyView> sky_views_of(const shared::AtmosphereUniform& air, const shared::FrameConstants& frame) {
  std::vector<shared::SkyView> views;
  if (!has_sky_view(air, frame.planet)) return views;
  const int count = static_cast<int>(frame.light_count);
  for (int i = 0; i < count; ++i)
    views.push_back(
        make_sky_view(air, frame.planet, frame.camera_up, i == 0 ? frame.sun_dir : frame.moon_dir, i, count));
  return views;
}

std::vector<uint8_t> Renderer::debug_picture(Parts& parts, const std::string& view, ImageRef image, size_t pixels) {
  std::vector<uint8_t> rgb(3 * pixels);
  if (parts.clouds) {
    const std::vector<uint8_t> rgba = parts.executor.read<uint8_t>(image);
    for (size_t k = 0; k < pixels; ++k) std::memcpy(&rgb[3 * k], &rgba[4 * k], 3);
    return rgb;
  }
  const std::array<uint8_t, 3> color = DebugViewPass::clear_color(view);
  for (size_t k = 0; k < pixels; ++k) std::memcpy(&rgb[3 * k], color.data(), 3);
  return rgb;
}

Renderer::Renderer(gpu::Device& device, TerrainSources sources, const Scene& scene, const SkySources& sky,
                   const WeatherSources& weather)
    : scene_(scene), device_(device) {
  const auto start = Clock::now();
  parts_ = std::make_unique<Parts>(device, std::move(sources), sky, weather, scene, timings_);
  set_time(parse_utc(scene.time));
  set_camera(scene.camera);
  timings_.startup_ms = ms_since(start);
}

Renderer::~Renderer() = default;

void Renderer::set_time(const UtcInstant& utc, const std::optional<UtcInstant>& sky) {
  parts_->time_s = utc.seconds_since_2000();
  parts_->sky = sky_bodies_at(sky.value_or(utc));
  parts_->light = FrameLight::from(parts_->sky, sun_illuminance_at_1au(scene_.atmosphere), scene_.night_sky.moon);
}

void Renderer::set_atmosphere(const AtmosphereParams& params) {
  if (spectral_groups(params) != spectral_groups(scene_.atmosphere))
    throw fail(ErrorKind::usage, "atmosphere.spectral: '{}' cannot follow '{}' in one renderer; make another",
               params.spectral, scene_.atmosphere.spectral);
  parts_->next_atmosphere = std::make_unique<AtmosphereTables>(device_, params, AtmosphereTables::Start::sliced);
}

double Renderer::atmosphere_progress() const {
  return parts_->next_atmosphere ? parts_->next_atmosphere->progress() : 1.0;
}

/// Some of the work on the next air, if there is any.
void Renderer::advance_atmosphere() {
  std::unique_ptr<AtmosphereTables>& next = parts_->next_atmosphere;
  if (!next || !next->advance(kAtmosphereSlice_ms)) return;
  parts_->atmosphere = std::move(next);
  scene_.atmosphere = parts_->atmosphere->params();
  parts_->light = FrameLight::from(parts_->sky, sun_illuminance_at_1au(scene_.atmosphere), scene_.night_sky.moon);
  if (parts_->clouds) parts_->clouds->upscaler.forget();
}

void Renderer::set_camera(const CameraParams& camera) {
  scene_.camera = camera;
  parts_->pose = resolve_camera(camera, parts_->terrain.heights());
  if (!parts_->told_of_lift) warn_if_lifted(parts_->pose);
  parts_->told_of_lift |= parts_->pose.lifted_from_m.has_value();
}

void Renderer::prefetch(const CameraParams& camera) {
  FrameInfo frame;
  frame.extent = {scene_.render.width, scene_.render.height};
  const CameraPose pose = resolve_camera(camera, parts_->terrain.heights());
  frame.camera_ecef_m = pose.ecef_m;
  frame.constants = make_frame_constants(pose, frame.extent, parts_->light, parts_->time_s, 0, 0, glm::vec2(0.0f));
  parts_->terrain.prefetch(frame);
}

CameraPose Renderer::pose() const { return parts_->pose; }

const Terrain& Renderer::terrain() const { return parts_->terrain; }

void Renderer::read_layers(FrameReadback& readback, const FrameOutputs& out) {
  Parts& p = *parts_;
  const size_t pixels = size_t{readback.extent.width} * readback.extent.height;
  readback.depth_m = p.executor.read<float>(out.depth_m);
  readback.albedo = floats_from_half(p.executor.read<uint16_t>(out.albedo));
  readback.background = p.executor.read<float>(out.background);
  if (p.clouds) {
    readback.cloud = p.executor.read<float>(out.cloud);
    readback.cloud_info = p.executor.read<float>(out.cloud_info);
    readback.shadow = p.executor.read<float>(out.shadow_layers);
    return;
  }
  readback.cloud.assign(4 * pixels, 0.0f);
  readback.cloud_info.assign(4 * pixels, 0.0f);
  readback.shadow.assign(2 * pixels, 1.0f);
  if (out.sun_visibility) {
    const std::vector<float> shares = p.executor.read<float>(out.sun_visibility);
    for (size_t k = 0; k < pixels; ++k)
      if (readback.depth_m[k] < 0.5f * shared::kFarDepth_m) readback.shadow[2 * k] = shares[k];
  }
  for (size_t k = 0; k < pixels; ++k) {
    readback.cloud[4 * k + 3] = 1.0f;
    readback.cloud_info[4 * k] = shared::kFarDepth_m;
  }
}

void Renderer::read_display(RenderResult& result, const FrameOutputs& out) {
  const std::vector<uint8_t> rgba = parts_->executor.read<uint8_t>(out.exposure.display);
  result.display_rgb.resize(rgba.size() / 4 * 3);
  for (size_t k = 0; k < rgba.size() / 4; ++k) std::memcpy(&result.display_rgb[3 * k], &rgba[4 * k], 3);
  result.ev100 = static_cast<double>(parts_->executor.read<float>(out.exposure.state)[0]);
}

/// The picture of the frames' mean.
void Renderer::show_mean(RenderResult& result, const FrameReadback& readback, double interval_s) {
  FrameGraph tone;
  const gpu::Image image = device_.create_image({.name = "mean", .extent = readback.extent, .format = Format::rgba32f});
  const gpu::ImageUpload upload{&image, std::as_bytes(std::span(readback.radiance))};
  device_.upload({&upload, 1});
  FrameOutputs out;
  out.exposure = parts_->exposure.add(tone, tone.import(image), scene_.render, interval_s);
  out.keep(tone, {.display = true});
  parts_->executor.run(tone);
  read_display(result, out);
}

/// How much the march of the last frame did.
void Renderer::count_work(const FrameOutputs& out, size_t pixels, bool live) {
  timings_.steps_per_px = timings_.samples_per_px = 0.0;
  if (!out.cloud_info) return;
  const std::vector<float> info = parts_->executor.read<float>(out.cloud_info);
  for (size_t k = 0; k < pixels; ++k) {
    const double samples = std::floor(static_cast<double>(info[4 * k + 3]) / 1024.0);
    timings_.samples_per_px += samples;
    timings_.steps_per_px += static_cast<double>(info[4 * k + 3]) - 1024.0 * samples;
  }
  timings_.samples_per_px /= static_cast<double>(pixels);
  timings_.steps_per_px /= static_cast<double>(pixels);
  const CloudLight::Work light = parts_->clouds ? parts_->clouds->lighting(live).inside.work() : CloudLight::Work{};
  timings_.light_cells = light.cells;
  timings_.light_fresh = light.fresh;
  timings_.light_refresh = light.refresh;
}

RenderResult Renderer::render(const RenderRequest& request) {
  if (parts_->reference) return render_reference(request);
  Parts& p = *parts_;
  const Extent2D extent{scene_.render.width, scene_.render.height};
  const uint32_t frames = std::max(1u, scene_.render.frames);
  const size_t pixels = size_t{extent.width} * extent.height;
  FrameReadback readback;
  readback.extent = extent;
  std::vector<double> sum;
  RenderResult result;
  result.pose = p.pose;
  timings_.frame_ms = timings_.readback_ms = timings_.terrain_ms = 0.0;

  advance_atmosphere();
  for (uint32_t i = 0; i < frames; ++i) {
    FrameGraph graph;
    FrameInfo frame;
    frame.extent = extent;
    frame.camera_ecef_m = p.pose.ecef_m;
    frame.time_s = p.time_s;
    const uint32_t number = request.frame_number * frames + i;
    frame.constants =
        make_frame_constants(p.pose, extent, p.light, p.time_s, number, scene_.render.seed, frame_jitter(i));
    frame.constants.night_illuminance =
        shared::night_sky_illuminance(static_cast<float>(scene_.night_sky.airglow_cd_m2), scene_.night_sky.stars);
    frame.buffer = graph.constants("frame", frame.constants);

    auto start = Clock::now();
    p.terrain.prepare(
        frame,
        {.complete = !request.incomplete_ok, .at_most_s = request.ground_wait_s, .on_progress = request.on_ground});
    timings_.terrain_ms += ms_since(start);

    start = Clock::now();
    const bool last = i + 1 == frames;
    const bool layers = request.layers && i == 0;
    const bool debug = !request.debug.empty();  // a picture of the first frame's insides
    const FrameOutputs out = p.add_frame(graph, frame, scene_,
                                         {.display = request.display && frames == 1 && !debug,
                                          .layers = layers,
                                          .work = request.count_work && last,
                                          .incomplete_ground = request.incomplete_ok,
                                          .debug = i == 0 ? request.debug : "",
                                          .interval_s = request.frame_interval_s,
                                          .sequence = request.frame_number > 0 && frames == 1,
                                          .live = request.live});
    p.executor.run(graph);
    timings_.frame_ms += ms_since(start);
    timings_.passes = p.executor.timings();

    start = Clock::now();
    if (request.layers || frames > 1) readback.radiance = p.executor.read<float>(out.radiance);
    if (layers) read_layers(readback, out);
    if (frames > 1) {
      // The mean of the frames' radiance; the other layers are those of frame 0, through the pixel centres.
      if (sum.empty()) sum.assign(readback.radiance.size(), 0.0);
      for (size_t k = 0; k < sum.size(); ++k) sum[k] += static_cast<double>(readback.radiance[k]);
      if (last)
        for (size_t k = 0; k < sum.size(); ++k) readback.radiance[k] = static_cast<float>(sum[k] / frames);
    }
    if (last && request.count_work) count_work(out, pixels, request.live);
    if (debug && i == 0) result.display_rgb = debug_picture(p, request.debug, out.debug, pixels);
    if (last && request.display && !debug && request.read_back) {
      if (frames > 1)
        show_mean(result, readback, request.frame_interval_s);
      else
        read_display(result, out);
    }
    timings_.readback_ms += ms_since(start);
  }
  timings_.frame_ms /= frames;
  const auto start = Clock::now();
  if (request.layers) result.layers = make_output_layers(readback, p.pose, request.wanted);
  timings_.readback_ms += ms_since(start);
  timings_.gpu_memory_bytes = device_.memory_bytes();
  return result;
}

}  // namespace nepho
