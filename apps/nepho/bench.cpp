#include "nepho/bench.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <ostream>

#include "astro/utc_time.h"
#include "base/error.h"
#include "base/log.h"
#include "geo/geodesic.h"
#include "io/png.h"
#include "nepho/raster_access.h"
#include "nepho/scene_sources.h"
#include "render/renderer.h"

namespace nepho {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n == 0 ? 0.0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// Memory of this process that is in RAM.
uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

/// The camera after `seconds` of a case's flight.
CameraParams camera_at(const BenchCase& c, double seconds) {
  CameraParams camera = c.scene.camera;
  if (c.speed_mps != 0.0) {
    const Geodetic from{rad_from_deg(camera.lat_deg), rad_from_deg(camera.lon_deg), 0.0};
    const GeodesicEnd to = geodesic_direct(from, rad_from_deg(camera.heading_deg), c.speed_mps * seconds);
    camera.lat_deg = to.point.lat_deg();
    camera.lon_deg = to.point.lon_deg();
    camera.heading_deg = deg_from_rad(to.azimuth_rad);
  }
  camera.heading_deg = std::fmod(camera.heading_deg + c.turn_deg_s * seconds + 720.0, 360.0);
  return camera;
}

using PassTimes = std::map<std::string, std::vector<double>>;  // by name, a frame each, ms

PassTimes passes_of(const RenderTimings& frame) {
  PassTimes passes;
  for (const gpu::PassTiming& pass : frame.passes) {
    std::vector<double>& times = passes[pass.name];
    times.resize(1, 0.0);
    times.front() += pass.gpu_ms;
  }
  return passes;
}

/// Dearest first.
void add_passes(std::vector<BenchPass>& to, PassTimes passes, uint32_t frames) {
  for (auto& [name, times] : passes) {
    times.resize(frames, 0.0);  // a pass that some frames do not have costs nothing in them
    to.push_back({name, *std::min_element(times.begin(), times.end()), median(times),
                  *std::max_element(times.begin(), times.end())});
  }
  std::stable_sort(to.begin(), to.end(),
                   [](const BenchPass& a, const BenchPass& b) { return a.median_ms > b.median_ms; });
}

std::string picture_name(const BenchResult& r, bool first) {
  return fmt::format("{}_{}x{}_{}_{}_{}.png", r.scene, r.size.width, r.size.height, r.quality, r.upscale,
                     first ? "first" : "last");
}

BenchResult measure(const BenchCase& c, const BenchRequest& request, const RasterAccess& rasters) {
  BenchResult r;
  r.scene = c.name;
  r.quality = c.scene.render.quality;
  r.size = {c.scene.render.width, c.scene.render.height};
  r.upscale = c.scene.render.upscale;
  r.frames = request.frames;

  const auto start = Clock::now();
  const SkySources sky = open_sky(rasters, c.scene);
  TerrainSources terrain = open_terrain(rasters, c.scene);
  const WeatherSources weather = open_weather(rasters, c.scene, terrain);
  gpu::Device device({.device = request.device, .validation = request.validation});
  r.device = device.info().name;
  r.driver = device.info().driver;
  Renderer renderer(device, std::move(terrain), c.scene, sky, weather);
  r.startup_ms = ms_since(start);

  const UtcInstant begin = parse_utc(c.scene.time);
  PassTimes passes;
  std::vector<double> frames, gpu;
  uint64_t resident = 0, gpu_bytes = 0;
  for (uint32_t i = 0; i <= request.warm_up + request.frames; ++i) {
    const bool measured = i > request.warm_up;
    if (i == request.warm_up + 1) {
      resident = resident_bytes();
      gpu_bytes = device.memory_bytes();
    }
    const double seconds = static_cast<double>(i) / request.fps;
    const auto frame = Clock::now();
    renderer.set_time(begin.plus_seconds(seconds));
    renderer.set_camera(camera_at(c, seconds));
    const bool last = i == request.warm_up + request.frames;
    const bool shown = !request.pictures.empty() && (i == 0 || last);
    const RenderResult drawn =
        renderer.render({.layers = false,
                     .frame_interval_s = i > 0 ? 1.0 / request.fps : 0.0,
                     .frame_number = i,
                     .live = true,
                     .read_back = shown,
                     .count_work = last,
                     .incomplete_ok = i > 0});
    const double ms = ms_since(frame) - renderer.timings().readback_ms;
    if (shown) write_png(request.pictures / picture_name(r, i == 0), r.size.width, r.size.height, drawn.display_rgb);
    if (i == 0) r.first_frame_ms = ms;
    if (i == 0) add_passes(r.first_passes, passes_of(renderer.timings()), 1);
    for (const std::string& message : device.take_validation_messages()) log_warning("{}", message);
    if (!measured) continue;
    frames.push_back(ms);
    double sum = 0.0;
    for (const auto& [name, times] : passes_of(renderer.timings())) {
      passes[name].push_back(times.front());
      sum += times.front();
    }
    gpu.push_back(sum);
  }
  add_passes(r.passes, std::move(passes), request.frames);
  r.frame_median_ms = median(frames);
  r.frame_min_ms = *std::min_element(frames.begin(), frames.end());
  r.frame_max_ms = *std::max_element(frames.begin(), frames.end());
  r.gpu_median_ms = median(gpu);
  r.steps_per_px = renderer.timings().steps_per_px;
  r.samples_per_px = renderer.timings().samples_per_px;
  r.gpu_images_bytes = device.memory_use().images;
  r.gpu_buffers_bytes = device.memory_use().buffers;
  r.gpu_host_visible_bytes = device.memory_use().host_visible;
  r.host_resident_bytes = resident_bytes();
  r.host_resident_growth_bytes = r.host_resident_bytes - std::min(resident, r.host_resident_bytes);
  r.gpu_growth_bytes = device.memory_bytes() - std::min(gpu_bytes, device.memory_bytes());
  return r;
}

}  // namespace

std::vector<BenchResult> run_bench(const BenchRequest& request, const RasterAccess& rasters, std::ostream& out) {
  std::vector<BenchResult> results;
  for (const BenchCase& c : request.cases) {
    results.push_back(measure(c, request, rasters));
    print_bench(out, results.back());
  }
  return results;
}

}  // namespace nepho
