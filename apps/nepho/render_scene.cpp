#include "nepho/render_scene.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "io/exr.h"
#include "io/png.h"
#include "nepho/scene_sources.h"
#include "render/renderer.h"
#include "scene/scene_json.h"

namespace nepho {

namespace {
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

ExrAttributes make_attributes(const Scene& scene, const CameraPose& pose, double ev100) {
  ExrAttributes a;
  a.longitude_deg = static_cast<float>(pose.at.lon_deg());
  a.latitude_deg = static_cast<float>(pose.at.lat_deg());
  a.altitude_m = static_cast<float>(pose.at.height_m - Geoid::egm96().undulation_m(pose.at.lat_rad, pose.at.lon_rad));
  a.cap_date = exr_cap_date(scene.time);
  a.utc_offset_s = 0.0f;
  a.white_luminance = 1.0f;
  // World: ECEF axes with the origin at the camera. Camera: x right, y up, z towards the viewer.
  glm::mat4 camera_from_world(1.0f);
  const dvec3 rows[] = {pose.axes.right, pose.axes.up, -pose.axes.forward};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) camera_from_world[c][r] = static_cast<float>(rows[r][c]);
  a.world_to_camera = camera_from_world;
  a.comments =
      "Nephoscope " NEPHO_VERSION "; R G B are cd/m2; worldToCamera has ECEF axes and its origin at the camera";
  a.strings["nepho:scene"] = scene_to_json(scene);
  a.floats["nepho:fov_deg"] = static_cast<float>(deg_from_rad(pose.fov_rad));
  a.floats["nepho:height_m"] = static_cast<float>(pose.at.height_m);
  a.floats["nepho:ev100"] = static_cast<float>(ev100);
  return a;
}

void write_timings(const std::filesystem::path& path, const RenderTimings& t, const gpu::DeviceInfo& device,
                   const Scene& scene, double total_startup_ms, double output_ms) {
  nlohmann::ordered_json j;
  j["device"] = device.name;
  j["driver"] = device.driver;
  j["size"] = fmt::format("{}x{}", scene.render.width, scene.render.height);
  j["startup_ms"] = total_startup_ms;
  j["startup"] = {{"renderer_ms", t.startup_ms},
                  {"atmosphere_ms", t.atmosphere_ms},
                  {"atmosphere_from_cache", t.atmosphere_cached},
                  {"clouds_ms", t.clouds_ms}};
  j["terrain_ms"] = t.terrain_ms;
  j["frame_ms"] = t.frame_ms;
  j["readback_ms"] = t.readback_ms;
  j["output_ms"] = output_ms;
  for (const gpu::PassTiming& p : t.passes) j["passes"].push_back({{"name", p.name}, {"gpu_ms", p.gpu_ms}});
  j["gpu_memory_bytes"] = t.gpu_memory_bytes;
  write_whole_file(path, [&](const std::filesystem::path& temporary) { write_text_file(temporary, j.dump(2) + "\n"); });
}

bool is_exr(const std::filesystem::path& path) {
  std::string e = path.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e == ".exr";
}

}  // namespace

void render_scene(const Scene& scene, const RenderOutputs& outputs, const RasterAccess& rasters) {
  const auto start = Clock::now();
  TerrainSources terrain = open_terrain(rasters, scene);  // bad files are told before a device is asked for
  const SkySources sky = open_sky(rasters, scene);
  const WeatherSources weather = open_weather(rasters, scene, terrain);
  gpu::Device device({.device = outputs.device, .validation = outputs.validation});
  Renderer renderer(device, std::move(terrain), scene, sky, weather);
  const double startup_ms = ms_since(start);

  RenderRequest request;
  request.display = std::any_of(outputs.images.begin(), outputs.images.end(), [](const auto& p) { return !is_exr(p); });
  request.layers = std::any_of(outputs.images.begin(), outputs.images.end(), [](const auto& p) { return is_exr(p); });
  request.wanted = outputs.layers;
  request.debug = outputs.debug;
  const RenderResult result = renderer.render(request);
  for (const std::string& message : device.take_validation_messages()) log_warning("{}", message);

  const auto written = Clock::now();
  for (const std::filesystem::path& path : outputs.images) {
    if (is_exr(path))
      write_exr(path, result.layers, make_attributes(scene, result.pose, result.ev100));
    else
      write_png(path, scene.render.width, scene.render.height, result.display_rgb);
  }
  const double output_ms = ms_since(written);
  if (!outputs.timings.empty())
    write_timings(outputs.timings, renderer.timings(), device.info(), scene, startup_ms, output_ms);
}

}  // namespace nepho
