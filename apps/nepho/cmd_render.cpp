#include "nepho/cmd_render.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

#include "base/error.h"
#include "base/files.h"
#include "scene/scene_json.h"
#include "scene/scene_validate.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::set<std::string> parse_layers(const std::string& text, const std::vector<std::string>& known) {
  std::set<std::string> layers;
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');) {
    if (!contains(known, name)) {
      const std::string nearest = nearest_name(name, known);
      throw fail(ErrorKind::usage, "--aov: '{}' is unknown; {}known: {}", name,
                 nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest), fmt::join(known, ", "));
    }
    layers.insert(name);
  }
  if (layers.empty()) throw fail(ErrorKind::usage, "--aov: no names given; known: {}", fmt::join(known, ", "));
  return layers;
}

}  // namespace

void RenderCommand::add_to(CLI::App& command, const Program& program) {
  scene_.add_to(command);
  add_repeated(command, "-o,--output", images_, "OUT",
               "picture to write: .png (8 bit, tone mapped) or .exr (radiance and layers); may be repeated");
  command.add_option("--aov", aov_, "layers of EXR files, separated by commas; default: all")->type_name("NAME,...");
  command
      .add_option("--resume", resume_,
                  "a picture of --quality reference (.exr with all layers) whose paths are gone on with")
      ->type_name("FILE.exr");
  command.add_option("--timings", timings_, "times of start-up and every pass, as JSON")->type_name("FILE.json");
  command.add_option("--save-scene", save_scene_, "the scene as drawn, with all options in it")->type_name("FILE.json");
  command.add_option("--device", device_, kDeviceHelp)->type_name("NAME");
  command
      .add_option("--debug", debug_,
                  fmt::format("a view of the renderer's insides in false colours, instead of the picture: {}",
                              fmt::join(program.debug_views, ", ")))
      ->type_name("NAME");
  command.add_flag(
      "--strict", strict_,
      "a raster of --terrain or --imagery that cannot be used, fails in part or is not in view is an error "
      "(exit status 3, nothing is written) instead of a warning");
  command.add_flag("--incomplete-ok", incomplete_ok_, "wait a second for the ground, then draw what is loaded");
  command.add_flag("--validation", validation_, "use the Vulkan validation layer")->group("");
}

RenderOutputs RenderCommand::outputs(const Program& program) const {
  if (!debug_.empty() && !contains(program.debug_views, debug_))
    throw fail(ErrorKind::usage, "--debug: {}", no_choice(debug_, program.debug_views));
  if (images_.empty() && save_scene_.empty())
    throw fail(ErrorKind::usage, "no output: give -o OUT.png, -o OUT.exr or --save-scene FILE.json");
  RenderOutputs outputs;
  for (const std::string& image : images_) {
    const std::string extension = lower_extension(image);
    if (extension != ".exr" && extension != ".png")
      throw fail(ErrorKind::usage, "-o: '{}' does not end in .exr or .png", image);
    outputs.images.emplace_back(image);
  }
  const bool any_png = std::any_of(images_.begin(), images_.end(),
                                   [](const std::string& image) { return lower_extension(image) == ".png"; });
  if (!debug_.empty() && !any_png)
    throw fail(ErrorKind::usage, "--debug: false colours are written as .png only; give -o OUT.png");
  if (!aov_.empty()) outputs.layers = parse_layers(aov_, program.layer_names);
  outputs.debug = debug_;
  outputs.timings = timings_;
  outputs.resume = resume_;
  outputs.device = device_;
  outputs.validation = validation_;
  outputs.strict = strict_;
  outputs.incomplete_ok = incomplete_ok_;
  return outputs;
}

void RenderCommand::check_reference(const Scene& scene, const RenderOutputs& wanted) const {
  const bool reference = scene.render.quality == "reference";
  if (reference && !wanted.debug.empty())
    throw fail(ErrorKind::usage, "--debug {}: shows the march, which --quality reference does not use", wanted.debug);
  if (!reference && !wanted.resume.empty())
    throw fail(ErrorKind::usage, "--resume: the quality is {}; only --quality reference can go on",
               scene.render.quality);
  for (const std::string& name : wanted.layers) {
    if (reference && (name == "surface.shadow" || name == "sun" || name == "sun.transmittance"))
      throw fail(ErrorKind::usage, "--aov {}: comes from shadow maps, which --quality reference does not use", name);
    if (!reference && (name == "samples" || name.starts_with("variance")))
      throw fail(ErrorKind::usage, "--aov {}: written by --quality reference only", name);
  }
}

void RenderCommand::run(const Program& program) const {
  const RenderOutputs wanted = outputs(program);
  const Scene scene = scene_.scene();
  check_reference(scene, wanted);
  if (!wanted.resume.empty() && !fs::exists(wanted.resume))
    throw fail(ErrorKind::input, "{}: no such file", wanted.resume.string());
  require_inputs(scene);
  for (const fs::path& image : wanted.images) require_writable(image);
  if (!timings_.empty()) require_writable(timings_);
  if (!save_scene_.empty()) save_scene(save_scene_, scene);
  if (!wanted.images.empty()) program.render(scene, wanted);
}

}  // namespace nepho
