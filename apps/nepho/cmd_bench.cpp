#include "nepho/cmd_bench.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "nepho/options.h"
#include "scene/parameter_text.h"
#include "scene/scene_json.h"
#include "scene/scene_validate.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

constexpr double kFlyThrough_mps = 250.0;  ///< of the scene `fly-through`

/// Scenes of every benchmark, in the order of the report.
const std::vector<std::string> kScenes = {"ground", "low-sun",       "inside",   "above", "10km",
                                          "400km",  "geostationary", "overcast", "clear", "fly-through"};

/// A name stands for data/scenes/NAME.json; anything that ends in .json for that file.
fs::path scene_file(const std::string& name) {
  const fs::path file = name.ends_with(".json") ? fs::path(name) : data_dir() / "scenes" / (name + ".json");
  if (fs::exists(file)) return file;
  if (name.ends_with(".json")) throw fail(ErrorKind::input, "--scene: {}: no such file", name);
  throw fail(ErrorKind::usage, "--scene: {}, or a scene file that ends in .json", no_choice(name, kScenes));
}

}  // namespace

void BenchCommand::add_to(CLI::App& command) {
  add_repeated(command, "--scene", scenes_, "NAME",
               fmt::format("what to draw: {}, all, or a scene file (default ground); may be repeated",
                           fmt::join(kScenes, ", ")));
  add_repeated(command, "--size", sizes_, "WxH", "of the picture, px (default 640x360); may be repeated");
  add_repeated(command, "--quality", qualities_, "NAME", "preset (default: the scene's); may be repeated");
  add_repeated(command, "--upscale", upscales_, "U",
               "pixels per marched pixel of clouds: 16, 4, 2 or 1 (default: the scene's); may be repeated");
  command.add_option("--frames", frames_, "frames to measure (default 16)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--warm-up", warm_up_, "frames before them, besides the first (default 16)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000000));
  command
      .add_option("--speed", speed_mps_,
                  fmt::format("the camera flies ahead, m/s (default 0; scene fly-through {:.0f})", kFlyThrough_mps))
      ->type_name("M_PER_S")
      ->each([this](const std::string&) { moves_ = true; });
  command.add_option("--turn", turn_deg_s_, "the camera turns to the right, deg/s (default 0)")->type_name("DEG_PER_S");
  command.add_option("--json", json_, "write all figures there")->type_name("FILE.json");
  command.add_option("--pictures", pictures_, "keep the first and the last picture of each case there, as PNG")
      ->type_name("FOLDER");
  command.add_option("--device", device_, kDeviceHelp)->type_name("NAME");
  command.add_flag("--validation", validation_, "use the Vulkan validation layer")->group("");
}

BenchRequest BenchCommand::request() const {
  BenchRequest request{
      .cases = {}, .frames = frames_, .warm_up = warm_up_, .device = device_, .validation = validation_, .pictures = pictures_};
  std::vector<std::string> names = scenes_.empty() ? std::vector<std::string>{"ground"} : scenes_;
  if (std::find(names.begin(), names.end(), "all") != names.end()) names = kScenes;
  const std::vector<std::string> as_is{""};
  for (const std::string& name : names) {
    const Scene scene = load_scene(scene_file(name).string());
    for (const std::string& size : sizes_.empty() ? std::vector<std::string>{"640x360"} : sizes_)
      for (const std::string& quality : qualities_.empty() ? as_is : qualities_)
        for (const std::string& upscale : upscales_.empty() ? as_is : upscales_) {
          BenchCase c{.name = fs::path(name).stem().string(), .scene = scene};
          set_size(c.scene.render, size);
          if (!quality.empty()) set_parameter(c.scene, "render.quality", quality, "--quality");
          if (!upscale.empty()) set_parameter(c.scene, "render.upscale", upscale, "--upscale");
          c.scene.render.frames = 1;
          if (c.scene.render.quality == "reference")
            throw fail(ErrorKind::usage,
                       "--quality reference: traces paths for as long as it is told; see nepho render --timings");
          c.speed_mps = moves_ ? speed_mps_ : name == "fly-through" ? kFlyThrough_mps : 0.0;
          c.turn_deg_s = turn_deg_s_;
          validate(c.scene, ErrorKind::usage);
          require_inputs(c.scene);
          request.cases.push_back(std::move(c));
        }
  }
  return request;
}

void BenchCommand::run(const Program& program) const {
  const BenchRequest wanted = request();
  if (!json_.empty()) require_writable(json_);
  if (!pictures_.empty() && !fs::is_directory(pictures_))
    throw fail(ErrorKind::usage, "--pictures: {}: no such folder", pictures_);
  const std::vector<BenchResult> results = program.bench(wanted, program.out);
  if (!json_.empty())
    write_whole_file(json_, [&](const fs::path& temporary) { write_text_file(temporary, bench_json(results)); });
}

}  // namespace nepho
