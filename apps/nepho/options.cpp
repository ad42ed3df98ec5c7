#include "nepho/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string_view>

#include "base/error.h"
#include "scene/parameter_text.h"
#include "scene/places.h"
#include "scene/scene_json.h"
#include "scene/scene_validate.h"
#include "scene/source_text.h"

namespace nepho {

namespace {

/// Options that set one parameter each.
struct Flag {
  const char* flag;
  const char* placeholder;
  const char* path;
};
constexpr Flag kFlags[] = {
    {"--height", "M", "camera.height_m"},
    {"--agl", "M", "camera.agl_m"},
    {"--heading", "DEG", "camera.heading_deg"},
    {"--pitch", "DEG", "camera.pitch_deg"},
    {"--roll", "DEG", "camera.roll_deg"},
    {"--fov", "DEG", "camera.fov_deg"},
    {"--time", "ISO8601", "time"},
    {"--quality", "NAME", "render.quality"},
    {"--upscale", "U", "render.upscale"},
    {"--coverage", "SHARE", "clouds.coverage"},
    {"--shafts", "NAME", "shafts.method"},
    {"--weather-seed", "N", "clouds.weather.seed"},
    {"--orders", "N", "atmosphere.scattering_orders"},
    {"--spectral", "NAME", "atmosphere.spectral"},
    {"--aerosol-optical-depth", "DEPTH", "atmosphere.mie.optical_depth"},
    {"--visibility", "M", "atmosphere.mie.visibility_m"},
    {"--ozone-du", "DU", "atmosphere.ozone.column_du"},
    {"--frames", "N", "render.frames"},
    {"--noise", "SHARE", "render.noise"},
    {"--seed", "N", "render.seed"},
    {"--water-mask", "FILE", "terrain.water_mask"},
    {"--host-budget", "MB", "terrain.host_budget_mb"},
    {"--gpu-budget", "MB", "terrain.gpu_budget_mb"},
    {"--disk-cache", "MB", "terrain.disk_cache_mb"},
};

constexpr const char* kUnderground = "--allow-underground";

/// Parameters that options of several parts set.
const std::map<std::string, std::string> kParts = {
    {"camera.lat_deg", "--at"},
    {"camera.lon_deg", "--at"},
    {"camera.look_at.lat_deg", "--look-at"},
    {"camera.look_at.lon_deg", "--look-at"},
    {"camera.look_at.height_m", "--look-at"},
    {"render.width", "--size"},
    {"render.height", "--size"},
    {"render.exposure_ev100", "--exposure"},
};

/// The option that sets the parameter at `path`, for messages; the path itself when there is none.
std::string option_of(const std::string& path) {
  for (const Flag& flag : kFlags)
    if (path == flag.path) return flag.flag;
  const auto part = kParts.find(path);
  if (part == kParts.end()) return path;
  const std::string member = path.substr(path.rfind('.') + 1);
  const std::string what = member.substr(0, member.find('_'));  // lat_deg -> lat
  return part->second == "--exposure" ? part->second : part->second + ": " + what;
}

std::string help_of(const Flag& flag) {
  Field field = parameter_field(flag.path);
  field.doc.erase(std::min(field.doc.find("; null:"), field.doc.size()));  // what JSON has for "not given"
  if (!field.choices.empty()) return fmt::format("{}: {}", field.doc, fmt::join(field.choices, ", "));
  if (field.text != TextKind::plain) return field.doc;
  return fmt::format("{} ({})", field.doc, field.range.text(field.unit));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts{""};
  for (const char c : text)
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// "LAT,LON" or "LAT,LON,HEIGHT".
std::vector<double> parse_position(const std::string& flag, const std::string& text, size_t max_parts) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() < 2 || parts.size() > max_parts)
    throw fail(ErrorKind::usage, "{}: '{}' is not LAT,LON{}", flag, text, max_parts > 2 ? "[,HEIGHT]" : "");
  std::vector<double> numbers;
  for (const std::string& part : parts) numbers.push_back(parse_number(part, flag));
  return numbers;
}

}  // namespace

void set_size(RenderParams& render, const std::string& text) {
  const std::vector<std::string> parts = split(text, text.find('X') == std::string::npos ? 'x' : 'X');
  if (parts.size() != 2) throw fail(ErrorKind::usage, "--size: '{}' is not WxH, such as 640x360", text);
  Scene sized;  // the parameters' own rules for whole numbers and ranges
  set_parameter(sized, "render.width", parts[0], option_of("render.width"));
  set_parameter(sized, "render.height", parts[1], option_of("render.height"));
  render.width = sized.render.width;
  render.height = sized.render.height;
}

CLI::Option* add_repeated(CLI::App& command, const std::string& flags, std::vector<std::string>& values,
                          const std::string& placeholder, const std::string& help) {
  return command.add_option(flags, values, help)->allow_extra_args(false)->type_name(placeholder);
}

void SceneOptions::add_text(CLI::App& command, const std::string& flag, const std::string& placeholder,
                            const std::string& help) {
  options_[flag] = command.add_option(flag, text_[flag], help)->type_name(placeholder)->take_last();
}

size_t SceneOptions::count(const std::string& flag) const { return options_.at(flag)->count(); }

void SceneOptions::add_to(CLI::App& command) {
  command.add_option("scene", file_, "scene file (docs/scene.md); without one, --place or --at, the place fuji")
      ->type_name("SCENE.json");
  add_text(command, "--place", "NAME", "a named view with its time: see nepho info");
  add_text(command, "--at", "LAT,LON", "where the camera is, in degrees; 2 m above the ground unless told otherwise");
  add_text(command, "--look-at", "LAT,LON[,HEIGHT]", "a point to look at; without a height the ground there");
  add_text(command, "--size", "WxH", "size of the picture in pixels, 1..16384 each");
  for (const Flag& flag : kFlags) add_text(command, flag.flag, flag.placeholder, help_of(flag));
  add_text(command, "--atmosphere", "NAME",
           fmt::format("clear air, instead of the scene's: {}", fmt::join(atmosphere_preset_names(), ", ")));
  add_text(command, "--exposure", "EV|auto", "exposure of PNG pictures at ISO 100");
  add_repeated(command, "--terrain", terrain_, "PATH[,KEY=VALUE]...",
               "elevation over the default Earth, later over earlier: file, folder, tiles with {z}/{x}/{y}, GDAL "
               "connection. Keys: opacity, vertical_datum=auto|ellipsoid|egm96, vertical_scale, "
               "encoding=auto|none|terrarium|mapbox, order, min_zoom, max_zoom; may be repeated");
  add_repeated(command, "--imagery", imagery_, "PATH[,KEY=VALUE]...",
               "imagery, in the same way. Keys: opacity, gamma, albedo_scale, stretch=auto|none|BLACK:WHITE, order, "
               "min_zoom, max_zoom; may be repeated");
  options_[kUnderground] = command.add_flag_function(
      kUnderground, [](int64_t) {}, "leave a camera that is under the ground there");
  add_text(command, "--sky", "NAME",
           fmt::format("clouds and their weather, instead of the scene's: {}", fmt::join(cloud_sky_names(), ", ")));
  add_text(command, "--weather", "FILE",
           "cloud cover of the whole globe, a raster (docs/data.md); not with --coverage");
  add_text(command, "--weather-tile", "FILE",
           "weather that repeats over the globe, a tileable RGBA picture; not with --coverage");
}

void SceneOptions::place_camera(Scene& scene) const {
  CameraParams& camera = scene.camera;
  if (given("--at")) {
    const std::vector<double> at = parse_position("--at", text_.at("--at"), 2);
    camera.lat_deg = at[0];
    camera.lon_deg = at[1];
    // The heights and the target of the scene belong to the scene's own place.
    camera.height_m.reset();
    camera.agl_m.reset();
    camera.look_at.reset();
  }
  if (given("--height") && given("--agl")) throw fail(ErrorKind::usage, "--height and --agl: give one of the two");
  if (given("--height")) camera.agl_m.reset();
  if (given("--agl")) camera.height_m.reset();
  const bool aimed = given("--heading") || given("--pitch");
  if (given("--look-at") && aimed)
    throw fail(ErrorKind::usage, "--look-at and {}: give one of the two", given("--heading") ? "--heading" : "--pitch");
  if (aimed) camera.look_at.reset();
  if (given("--look-at")) {
    const std::vector<double> target = parse_position("--look-at", text_.at("--look-at"), 3);
    camera.look_at = LookAt{.lat_deg = target[0], .lon_deg = target[1], .height_m = {}};
    if (target.size() > 2) camera.look_at->height_m = target[2];
  }
}

void SceneOptions::set_air(AtmosphereParams& air) const {
  if (given("--atmosphere")) {
    const std::string& name = text_.at("--atmosphere");
    const std::optional<AtmosphereParams> preset = atmosphere_preset(name);
    if (!preset) throw fail(ErrorKind::usage, "--atmosphere: {}", no_choice(name, atmosphere_preset_names()));
    air = *preset;
  }
  const bool depth = given("--aerosol-optical-depth"), visibility = given("--visibility");
  if (depth && visibility)
    throw fail(ErrorKind::usage, "--aerosol-optical-depth and --visibility: give one of the two");
  if (depth) air.mie.visibility_m.reset();
  if (visibility) air.mie.optical_depth.reset();
}

void SceneOptions::set_clouds(CloudParams& clouds) const {
  if (given("--sky")) {
    const std::string& name = text_.at("--sky");
    const std::optional<CloudParams> sky = cloud_sky(name);
    if (!sky) throw fail(ErrorKind::usage, "--sky: {}", no_choice(name, cloud_sky_names()));
    clouds = *sky;
  }
  const char* chosen = nullptr;
  for (const char* flag : {"--weather", "--weather-tile", "--coverage"}) {
    if (!given(flag)) continue;
    if (chosen) throw fail(ErrorKind::usage, "{} and {}: give one of the two", chosen, flag);
    chosen = flag;
    if (flag == std::string_view("--coverage")) continue;  // set as one of kFlags
    if (text_.at(flag).empty()) throw fail(ErrorKind::usage, "{}: the name of the file is empty", flag);
    clouds.weather.source = flag == std::string_view("--weather") ? "raster" : "tile";
    clouds.weather.file = text_.at(flag);
    clouds.coverage.reset();
  }
}

Scene SceneOptions::scene() const {
  if (given("--place") && given("--at")) throw fail(ErrorKind::usage, "--place and --at: give one of the two");
  Scene scene;
  if (!file_.empty()) scene = load_scene(file_);
  if (given("--place") || (file_.empty() && !given("--at"))) {
    const Place place = find_place(given("--place") ? text_.at("--place") : "fuji");
    scene.camera = place.camera;
    scene.time = place.time;
  }
  place_camera(scene);
  set_air(scene.atmosphere);
  set_clouds(scene.clouds);
  for (const Flag& flag : kFlags)
    if (given(flag.flag)) set_parameter(scene, flag.path, text_.at(flag.flag), flag.flag);
  if (given("--size")) set_size(scene.render, text_.at("--size"));
  if (given("--exposure")) {
    const std::string& exposure = text_.at("--exposure");
    scene.render.exposure_ev100.reset();
    if (exposure != "auto") scene.render.exposure_ev100 = parse_number(exposure, "--exposure");
  }
  for (const std::string& text : terrain_) scene.terrain.elevation.push_back(parse_elevation_source(text, "--terrain"));
  for (const std::string& text : imagery_) scene.imagery.files.push_back(parse_imagery_source(text, "--imagery"));
  if (count(kUnderground) > 0) scene.camera.allow_underground = true;
  RenderParams& render = scene.render;
  if (render.quality == "reference") {
    // Neither a number of paths nor a noise: one that shows little on a screen.
    constexpr double kDefaultNoise = 0.02;
    if (render.noise == 0.0 && render.frames == 1 && !given("--frames")) render.noise = kDefaultNoise;
  } else if (given("--noise")) {
    throw fail(ErrorKind::usage, "--noise: the quality is {}; it stops --quality reference only", render.quality);
  }
  validate(scene, ErrorKind::usage, option_of);
  return scene;
}

void require_inputs(const Scene& scene) {
  namespace fs = std::filesystem;
  for (const std::string& file : local_files(scene)) {
    // Of tiles, "dir/{z}/{x}/{y}.png", the folder that holds them.
    const size_t brace = file.find('{');
    const fs::path place = brace == std::string::npos ? fs::path(file) : fs::path(file.substr(0, brace)).parent_path();
    if (place.empty()) continue;
    std::error_code ec;
    const fs::file_status status = fs::status(place, ec);
    if (!fs::exists(status) && !fs::exists(file, ec))
      throw fail(ErrorKind::input, "{}: no such {}", file,
                 brace == std::string::npos ? "file" : "file, and no such folder of tiles");
    // Reading these could wait for ever.
    if (fs::is_fifo(status) || fs::is_socket(status) || fs::is_character_file(status) || fs::is_block_file(status))
      throw fail(ErrorKind::input, "{}: is a pipe or device; give a file", file);
  }
}

}  // namespace nepho
