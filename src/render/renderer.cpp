#include "render/renderer_parts.h"

#include <glm/gtc/packing.hpp>

#include <chrono>
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
constexpr float kFroxelsBelow_m = 30e3f;  ///< cameras that light shafts by froxels of themselves

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
/// The cheapest preset lights clouds by octaves.
CloudParams as_drawn(const Scene& scene) {
  CloudParams clouds = scene.clouds;
  if (scene.render.quality == "low") clouds.multiple_scattering = "octaves";
  return clouds;
}
}  // namespace

Renderer::Parts::Parts(gpu::Device& device, TerrainSources sources, const SkySources& sky_sources,
                       const WeatherSources& weather, const Scene& scene, RenderTimings& timings)
    : executor(device),
      terrain(device, std::move(sources), scene.terrain),
      terrain_shadow_map(device),
      terrain_shadow(device),
      night_sky(device, sky_sources),
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

namespace {

/// References to what a frame leaves behind.
struct FrameOutputs {
  Terrain::Outputs terrain;
  NightSky::Refs night_sky;
  ImageRef background, radiance, cloud, cloud_info, shadow_layers, debug;
  ExposurePasses::Outputs exposure;
};

}  // namespace

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
    frame.constants = make_frame_constants(p.pose, extent, p.light, p.time_s, i, scene_.render.seed, frame_jitter(i));
    frame.constants.night_illuminance =
        shared::night_sky_illuminance(static_cast<float>(scene_.night_sky.airglow_cd_m2), scene_.night_sky.stars);
    frame.buffer = graph.constants("frame", frame.constants);

    auto start = Clock::now();
    p.terrain.prepare(
        frame,
        {.complete = !request.incomplete_ok, .at_most_s = request.ground_wait_s, .on_progress = request.on_ground});
    timings_.terrain_ms += ms_since(start);

    start = Clock::now();
    FrameOutputs out;
    const std::vector<shared::SkyView> views = sky_views_of(p.atmosphere->uniform(), frame.constants);
    const AtmosphereTables::Refs atmosphere = p.atmosphere->add(graph, views);
    out.night_sky = p.night_sky.add(graph, frame, scene_.night_sky, p.sky);
    out.terrain = p.terrain.add(graph, frame);
    BackgroundPass::Inputs background{.terrain = out.terrain,
                                      .atmosphere = atmosphere,
                                      .night_sky = out.night_sky,
                                      .has_sky_view = !views.empty(),
                                      .night = NightSky::shows(frame.constants) || frame.constants.light_count > 1,
                                      .sun_visibility = {},
                                      .wind_mps = static_cast<float>(scene_.terrain.water_wind_mps)};
    CloudDensityRefs density;
    CloudShadowRefs shadow;
    CloudLight::Refs light;
    const bool terrain_shades =
        scene_.terrain.shadows && p.terrain_shadow_map.update(p.terrain.heights(), frame, request.incomplete_ok);
    const TerrainVolumeRefs terrain_air =
        terrain_shades ? p.terrain_shadow_map.add_volume(graph, frame) : TerrainVolumeRefs{};
    if (p.clouds) {
      density = import_cloud_density(graph, frame, p.clouds->clouds);
      p.clouds->ground.update(p.terrain.heights(), p.terrain.imagery(), p.clouds->light.region(frame));
      const GroundMap::Refs ground = p.clouds->ground.import_into(graph);
      light = p.clouds->light.add(graph, frame,
                                  {.depth_m = out.terrain.depth_m,
                                   .density = density,
                                   .atmosphere = &atmosphere,
                                   .terrain_shadow = terrain_air.shadow,
                                   .terrain_map = terrain_air.map,
                                   .ground = p.clouds->ground.map(),
                                   .ground_albedo = ground.albedo,
                                   .ground_height = ground.height_m});
      background.cloud_light = light.ground;
      shadow = p.clouds->shadow_maps.add(graph, frame, density);
      background.sun_visibility = p.clouds->shadow.add(graph, frame, out.terrain, shadow);
    }
    const ShaftPass::Air air{
        .atmosphere = atmosphere,
        .uniform = &p.atmosphere->uniform(),
        .shadow = shadow,
        .terrain = terrain_air,
        .terrain_top_m = terrain_shades ? p.terrain_shadow_map.shade_top_m(frame) : 0.0,
        .cloud_top_m = p.clouds ? static_cast<double>(p.clouds->clouds.constants().hull_high_m) : 0.0,
        .ground_m = p.terrain.ground_height_m(p.pose.at.lat_rad, p.pose.at.lon_rad),
        .ground_albedo = scene_.atmosphere.ground_albedo};
    background.shafts = p.shafts.add_constants(graph, frame, scene_.shafts, scene_.haze, air);
    background.haze_layers = static_cast<uint32_t>(drawn_haze(scene_.haze).size());
    if (terrain_shades)
      background.sun_visibility = p.terrain_shadow.add(
          graph, frame, out.terrain, p.terrain_shadow_map.import_into(graph), background.sun_visibility);
    out.background = p.background.add(graph, frame, scene_.atmosphere, background);
    CloudMarchPass::Outputs marched;
    if (p.clouds) {
      marched = p.clouds->march.add(
          graph, frame, {.depth_m = out.terrain.depth_m, .atmosphere = atmosphere, .density = density, .light = light});
      out.cloud_info = marched.info;
    }
    ShaftMethod method = shaft_method(scene_.shafts, scene_.render.quality);
    // A frustum grid's cells are too long for the limb.
    if (scene_.shafts.method == "auto" && method == ShaftMethod::froxel &&
        frame.constants.planet.camera_height_m > kFroxelsBelow_m)
      method = ShaftMethod::shadow_length;
    const FroxelRefs froxels = method == ShaftMethod::froxel
                                   ? p.shafts.add_froxels(graph, frame, scene_.shafts, scene_.haze, method, air, false)
                                   : FroxelRefs{};
    const ShaftPass::Outputs aired = p.shafts.add(graph, frame, scene_.shafts, scene_.haze, method, air,
                                                  {.depth_m = out.terrain.depth_m,
                                                   .background = out.background,
                                                   .cloud = marched.radiance,
                                                   .cloud_near = marched.near,
                                                   .cloud_depths = marched.depths,
                                                   .froxels = froxels});
    out.background = out.radiance = aired.background;
    out.cloud = aired.cloud;
    if (p.clouds) {
      out.radiance = p.composite.add(graph, frame, out.background, out.cloud);
      if (!request.debug.empty() && i == 0) {
        out.debug = p.clouds->debug.add(graph, frame, request.debug, out.terrain.depth_m, density, marched, shadow);
        graph.keep(out.debug);
      }
    }
    const bool last = i + 1 == frames;
    const bool debug = !request.debug.empty();  // a picture of the first frame's insides
    if (request.display && frames == 1 && !debug) {
      out.exposure = p.exposure.add(graph, out.radiance, scene_.render, request.frame_interval_s);
      graph.keep(out.exposure.display);
      graph.keep(out.exposure.state);
    }
    graph.keep(out.radiance);
    if (request.layers && i == 0) {
      graph.keep(out.terrain.depth_m);
      graph.keep(out.terrain.albedo);
      graph.keep(out.background);
      if (p.clouds) {
        graph.keep(out.cloud);
        graph.keep(out.cloud_info);
        out.shadow_layers = p.clouds->shadow.add_layers(graph, frame,
                                                        {.depth_m = out.terrain.depth_m,
                                                         .visibility = background.sun_visibility,
                                                         .cloud_radiance = out.cloud,
                                                         .cloud_info = out.cloud_info},
                                                        shadow);
        graph.keep(out.shadow_layers);
      } else if (background.sun_visibility) {
        graph.keep(background.sun_visibility);
      }
    }
    p.executor.run(graph);
    timings_.frame_ms += ms_since(start);
    timings_.passes = p.executor.timings();

    start = Clock::now();
    if (request.layers || frames > 1) readback.radiance = p.executor.read<float>(out.radiance);
    if (request.layers && i == 0) {
      readback.depth_m = p.executor.read<float>(out.terrain.depth_m);
      readback.albedo = floats_from_half(p.executor.read<uint16_t>(out.terrain.albedo));
      readback.background = p.executor.read<float>(out.background);
      if (p.clouds) {
        readback.cloud = p.executor.read<float>(out.cloud);
        readback.cloud_info = p.executor.read<float>(out.cloud_info);
        readback.shadow = p.executor.read<float>(out.shadow_layers);
      } else {
        readback.cloud.assign(4 * pixels, 0.0f);
        readback.cloud_info.assign(4 * pixels, 0.0f);
        readback.shadow.assign(2 * pixels, 1.0f);
        if (background.sun_visibility) {
          const std::vector<float> shares = p.executor.read<float>(background.sun_visibility);
          for (size_t k = 0; k < pixels; ++k)
            if (readback.depth_m[k] < 0.5f * shared::kFarDepth_m) readback.shadow[2 * k] = shares[k];
        }
        for (size_t k = 0; k < pixels; ++k) {
          readback.cloud[4 * k + 3] = 1.0f;
          readback.cloud_info[4 * k] = shared::kFarDepth_m;
        }
      }
    }
    if (frames > 1) {
      // The mean of the frames' radiance; the other layers are those of frame 0, through the pixel centres.
      if (sum.empty()) sum.assign(readback.radiance.size(), 0.0);
      for (size_t k = 0; k < sum.size(); ++k) sum[k] += static_cast<double>(readback.radiance[k]);
      if (last)
        for (size_t k = 0; k < sum.size(); ++k) readback.radiance[k] = static_cast<float>(sum[k] / frames);
    }
    if (debug && i == 0) result.display_rgb = debug_picture(p, request.debug, out.debug, pixels);
    if (last && request.display && !debug) {
      if (frames > 1) {
        FrameGraph tone;
        const gpu::Image image = device_.create_image({.name = "mean", .extent = extent, .format = Format::rgba32f});
        const gpu::ImageUpload upload{&image, std::as_bytes(std::span(readback.radiance))};
        device_.upload({&upload, 1});
        out.exposure = p.exposure.add(tone, tone.import(image), scene_.render, request.frame_interval_s);
        tone.keep(out.exposure.display);
        tone.keep(out.exposure.state);
        p.executor.run(tone);
      }
      const std::vector<uint8_t> rgba = p.executor.read<uint8_t>(out.exposure.display);
      result.display_rgb.resize(3 * pixels);
      for (size_t k = 0; k < pixels; ++k) std::memcpy(&result.display_rgb[3 * k], &rgba[4 * k], 3);
      result.ev100 = static_cast<double>(p.executor.read<float>(out.exposure.state)[0]);
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
