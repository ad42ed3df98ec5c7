#include "nepho/render_scene.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "base/progress.h"
#include "io/exr.h"
#include "io/png.h"
#include "nepho/ground_report.h"
#include "nepho/scene_sources.h"
#include "render/renderer.h"
#include "scene/scene_json.h"

namespace nepho {

namespace {

/// A still of a ground that was not waited for at all would be a ball of a few hundred triangles.
constexpr double kIncompleteWait_s = 1.0;
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

nlohmann::ordered_json work_of(const ReferenceCounts& c) {
  const double paths = std::max(static_cast<double>(c.paths), 1.0), seconds = 1e-3 * c.trace_ms;
  return {{"paths", c.paths},
          {"noise", c.noise},
          {"trace_ms", c.trace_ms},
          {"shade_ms", c.shade_ms},
          {"paths_per_s", seconds > 0.0 ? paths / seconds : 0.0},
          {"vertices_per_path", static_cast<double>(c.vertices) / paths},
          {"density_reads_per_path", static_cast<double>(c.density_reads) / paths},
          {"majorant_reads_per_path", static_cast<double>(c.moves) / paths},
          {"majorants_exceeded_share",
           static_cast<double>(c.overruns) / std::max(static_cast<double>(c.density_reads), 1.0)}};
}

void write_timings(const std::filesystem::path& path, const RenderTimings& t, const gpu::DeviceInfo& device,
                   const Scene& scene, const Terrain& terrain, double total_startup_ms, double output_ms) {
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
  if (t.reference.paths > 0) j["reference"] = work_of(t.reference);
  j["gpu_memory_bytes"] = t.gpu_memory_bytes;
  j["terrain"] = ground_report(terrain);
  write_whole_file(path, [&](const std::filesystem::path& temporary) { write_text_file(temporary, j.dump(2) + "\n"); });
}

bool is_exr(const std::filesystem::path& path) {
  std::string e = path.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e == ".exr";
}

/// A picture to go on with, if it is of this very scene.
ExrFile read_earlier(const std::filesystem::path& path, const Scene& scene) {
  ExrFile file = read_exr(path);
  const auto text = file.attributes.strings.find("nepho:scene");
  if (text == file.attributes.strings.end())
    throw fail(ErrorKind::input,
               "{}: no scene in its header; only a picture of --quality reference can be gone on with", path.string());
  // When to stop, and how to show it, may differ.
  Scene was = scene_from_json(text->second, path.string());
  const RenderParams& now = scene.render;
  RenderParams& r = was.render;
  r.frames = now.frames;
  r.noise = now.noise;
  r.exposure_ev100 = now.exposure_ev100;
  r.min_ev100 = now.min_ev100;
  r.max_ev100 = now.max_ev100;
  r.exposure_compensation_ev = now.exposure_compensation_ev;
  r.exposure_adaptation_s = now.exposure_adaptation_s;
  r.white_balance_k = now.white_balance_k;
  r.tone_curve = now.tone_curve;
  if (scene_to_json(was) != scene_to_json(scene))
    throw fail(ErrorKind::input, "{}: made from another scene; give the same scene, options and seed to go on",
               path.string());
  return file;
}

std::string duration_text(double seconds) {
  const auto s = static_cast<int64_t>(std::min(seconds, 3.6e6) + 0.5);
  return s < 120    ? fmt::format("{} s", s)
         : s < 7200 ? fmt::format("{} min", s / 60)
                    : fmt::format("{:.1f} h", static_cast<double>(s) / 3600.0);
}

/// While it lives, an interrupt (SIGINT, SIGTERM) is remembered instead of ending the program; a second one ends it.
class InterruptGuard {
 public:
  InterruptGuard() {
    interrupted_ = 0;
    was_int_ = std::signal(SIGINT, on_signal);
    was_term_ = std::signal(SIGTERM, on_signal);
  }
  ~InterruptGuard() {
    std::signal(SIGINT, was_int_);
    std::signal(SIGTERM, was_term_);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool interrupted() { return interrupted_ != 0; }

 private:
  static void on_signal(int signal) {
    interrupted_ = 1;
    std::signal(signal, SIG_DFL);
  }
  static inline volatile std::sig_atomic_t interrupted_ = 0;
  void (*was_int_)(int) = SIG_DFL;
  void (*was_term_)(int) = SIG_DFL;
};

}  // namespace

void render_scene(const Scene& scene, const RenderOutputs& outputs, const RasterAccess& rasters) {
  const auto start = Clock::now();
  const ExrFile earlier = outputs.resume.empty() ? ExrFile{} : read_earlier(outputs.resume, scene);
  const SkySources sky = open_sky(rasters, scene);  // before files that may hang
  // Bad files are told before a device is asked for.
  TerrainSources terrain = open_terrain(rasters, scene, outputs.strict ? BadSource::error : BadSource::warning);
  const std::vector<RasterInfo> named = named_rasters(terrain, scene);
  const WeatherSources weather = open_weather(rasters, scene, terrain);
  gpu::Device device({.device = outputs.device, .validation = outputs.validation});
  Renderer renderer(device, std::move(terrain), scene, sky, weather);
  const double startup_ms = ms_since(start);

  RenderRequest request;
  request.display = std::any_of(outputs.images.begin(), outputs.images.end(), [](const auto& p) { return !is_exr(p); });
  request.layers = std::any_of(outputs.images.begin(), outputs.images.end(), [](const auto& p) { return is_exr(p); });
  request.wanted = outputs.layers;
  request.debug = outputs.debug;
  if (!outputs.resume.empty()) request.resume = &earlier.image;
  request.incomplete_ok = outputs.incomplete_ok;
  request.ground_wait_s = kIncompleteWait_s;
  std::optional<Progress> ground;
  request.on_ground = [&](size_t done, size_t of) {
    if (done == 0 || !ground) ground.emplace("ground");
    ground->update(of > 0 ? static_cast<double>(done) / static_cast<double>(of) : 1.0, fmt::format("{} tiles", of));
    if (done >= of) ground.reset();
  };
  std::optional<Progress> progress;
  std::optional<InterruptGuard> guard;
  if (scene.render.quality == "reference") {
    guard.emplace();
    progress.emplace("paths");
    request.on_progress = [&](const ReferenceProgress& at) {
      progress->update(at.fraction, fmt::format("{:.0f} a pixel, noise {:.1f} %, {} left", at.paths, 100.0 * at.noise,
                                                duration_text(at.left_s)));
      return !InterruptGuard::interrupted();
    };
  }
  const RenderResult result = [&] {
    try {
      return renderer.render(request);
    } catch (const Error& e) {
      if (!request.resume || e.kind() != ErrorKind::input) throw;
      throw fail(ErrorKind::input, "{}: {}", outputs.resume.string(), e.what());
    }
  }();
  progress.reset();
  ground.reset();
  for (const std::string& message : device.take_validation_messages()) log_warning("{}", message);

  const std::string failure = first_failure(renderer.terrain());  // warned of when it happened
  if (outputs.strict && !failure.empty()) throw fail(ErrorKind::input, "{} (--strict)", failure);
  for (const std::string& line : out_of_view(named, renderer.terrain())) {
    if (outputs.strict) throw fail(ErrorKind::input, "{} (--strict)", line);
    log_warning("{}", line);
  }

  const auto written = Clock::now();
  for (const std::filesystem::path& path : outputs.images) {
    if (is_exr(path))
      write_exr(path, result.layers, make_attributes(scene, result.pose, result.ev100));
    else
      write_png(path, scene.render.width, scene.render.height, result.display_rgb);
  }
  const double output_ms = ms_since(written);
  if (!outputs.timings.empty())
    write_timings(outputs.timings, renderer.timings(), device.info(), scene, renderer.terrain(), startup_ms, output_ms);
  if (result.interrupted)
    throw fail(ErrorKind::interrupted,
               "interrupted; the picture so far is written: {:.0f} paths a pixel, noise {:.1f} %; "
               "go on with --resume and its .exr",
               result.reference.paths, 100.0 * result.reference.noise);
}

}  // namespace nepho
