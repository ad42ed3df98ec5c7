#include "scene/scene_json.h"
#include "reading_fails.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "scene/scene_fields.h"
#include "scene/scene_validate.h"

using namespace nepho;
using nepho::test::reading_fails;
namespace fs = std::filesystem;

namespace {

/// Gives every parameter another allowed value than its default, and every optional group a value.
class Changer : public FieldVisitor {
 public:
  int leaves = 0;

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    ++leaves;
    std::visit([&](auto* p) { change(field, *p); }, value);
  }
  void on_group(const Field&, const std::function<void()>& members) override { members(); }
  void on_items(const Field&, const Items& items) override {
    items.resize(items.max);
    for (size_t i = 0; i < items.size(); ++i) items.visit(*this, i);
  }

 private:
  // A third of the way is no round number: it shows a loss of digits.
  static void change(const Field& f, double& v) { v += ((v < f.range.max / 2 ? f.range.max : f.range.min) - v) / 3; }
  static void change(const Field& f, std::optional<double>& v) { change(f, v.emplace(f.range.min)); }
  static void change(const Field& f, glm::dvec3& v) {
    for (int i = 0; i < 3; ++i) change(f, v[i]);
  }
  static void change(const Field&, uint32_t& v) { v += 7; }
  static void change(const Field&, int& v) { v += 1; }
  static void change(const Field&, bool& v) { v = !v; }
  static void change(const Field& f, std::string& v) {
    if (f.text == TextKind::utc)
      v = "1999-12-31T23:59:59.25Z";
    else
      v = f.choices.empty() ? v + "x" : f.choices[v == f.choices[1] ? 0 : 1];
  }
  static void change(const Field&, Stretch& v) {
    v = {.kind = Stretch::Kind::range, .low = -1.0 / 3.0, .high = 1e4 / 7.0};
  }
  static void change(const Field&, std::vector<std::string>& v) { v = {"a b.tif", "\"ä\".tif"}; }
};

/// Number of members of an aggregate.
struct Anything {
  template <typename T>
  operator T() const;
};
template <typename T, typename... Args>
constexpr size_t member_count() {
  if constexpr (requires { T{Args{}..., Anything{}}; })
    return member_count<T, Args..., Anything>();
  else
    return sizeof...(Args);
}

}  // namespace

TEST_CASE("the table of parameters has every member of the scene's structs") {
  const std::vector<std::string> paths = parameter_paths();
  const auto members_of = [&](const std::string& group) {
    std::set<std::string> names;
    for (const std::string& path : paths)
      if (path.starts_with(group))
        names.insert(path.substr(group.size(), path.find_first_of(".[", group.size()) - group.size()));
    return names.size();
  };
  CHECK(members_of("") == member_count<Scene>());
  CHECK(members_of("camera.") == member_count<CameraParams>());
  CHECK(members_of("camera.look_at.") == member_count<LookAt>());
  CHECK(members_of("atmosphere.") == member_count<AtmosphereParams>());
  CHECK(members_of("atmosphere.rayleigh.") == member_count<RayleighParams>());
  CHECK(members_of("atmosphere.mie.") == member_count<MieParams>());
  CHECK(members_of("atmosphere.ozone.") == member_count<OzoneParams>());
  CHECK(members_of("night_sky.") == member_count<NightSkyParams>());
  CHECK(members_of("clouds.") == member_count<CloudParams>());
  CHECK(members_of("clouds.layers[0].") == member_count<CloudLayer>());
  CHECK(members_of("clouds.layers[0].density_profile.") == member_count<DensityProfile>());
  CHECK(members_of("clouds.weather.") == member_count<WeatherParams>());
  CHECK(members_of("clouds.noise.") == member_count<CloudNoiseParams>());
  CHECK(members_of("clouds.shadows.") == member_count<CloudShadowParams>());
  for (const char* texture : {"shape.", "detail.", "turbulence."})
    CHECK(members_of(std::string("clouds.noise.") + texture) == member_count<NoiseTextureParams>());
  CHECK(members_of("terrain.") == member_count<TerrainParams>());
  CHECK(members_of("terrain.elevation[0].") == member_count<ElevationSource>());
  CHECK(members_of("imagery.files[0].") == member_count<ImagerySource>());
  CHECK(members_of("imagery.") == member_count<ImageryParams>());
  CHECK(members_of("render.") == member_count<RenderParams>());
}

TEST_CASE("an empty object is the scene of all defaults, and that is valid") {
  CHECK(scene_from_json("{}", "s.json") == Scene{});
  CHECK_NOTHROW(validate(Scene{}, ErrorKind::input));
}

TEST_CASE("a scene with every parameter changed comes back equal from JSON, bit for bit") {
  Scene scene;
  Changer changer;
  visit_fields(changer, scene);
  CHECK(changer.leaves > 40);
  scene.camera.agl_m.reset();                    // excludes height_m
  scene.render.upscale = 16;                     // 1, 2, 4 or 16
  scene.atmosphere.polar_radius_m = 1e9 / 3.03;  // not above the equatorial one
  scene.atmosphere.mie.extinction_per_m = scene.atmosphere.mie.scattering_per_m = {1.0 / 3e5, 1.0 / 7e5, 1.0 / 9e5};
  scene.atmosphere.mie.visibility_m.reset();  // excludes optical_depth
  scene.atmosphere.rayleigh.scattering_per_m = {1.0 / 3e6, 1.0 / 7e6, 1.0 / 9e6};
  scene.atmosphere.ozone.absorption_per_m = {1.0 / 3e7, 1.0 / 7e7, 1.0 / 9e7};
  scene.atmosphere.ozone.column_du = 1000.0 / 3.0;
  scene.atmosphere.rayleigh.scale_height_m = 1e5 / 3.0;  // 3 of them fit below the top
  scene.atmosphere.mie.scale_height_m = 1e4 / 3.0;
  scene.render.min_ev100 = -20.0 / 3.0;  // not above max_ev100
  scene.clouds.shadows.cascades = 4;
  scene.shafts.downscale = 8;
  for (HazeLayer& layer : scene.haze.layers) layer.top_m = 3e4;                 // above bottom_m
  for (ElevationSource& source : scene.terrain.elevation) source.max_zoom = 7;  // not below min_zoom
  for (ImagerySource& source : scene.imagery.files) source.max_zoom = 7;
  const std::string text = scene_to_json(scene);
  const Scene back = scene_from_json(text, "s.json");
  CHECK(back == scene);
  CHECK(scene_to_json(back) == text);
  CHECK_FALSE(scene == Scene{});
}

TEST_CASE("the JSON of a scene names every parameter") {
  Scene scene;
  scene.camera.look_at.emplace();
  scene.haze.layers.emplace_back();
  scene.terrain.elevation.push_back({.path = "a.tif", .opacity = 0.5});
  scene.imagery.files.push_back({.path = "b.tif", .opacity = 0.5});
  const std::string text = scene_to_json(scene);
  for (const std::string& path : parameter_paths()) {
    CAPTURE(path);
    CHECK(text.find('"' + path.substr(path.rfind('.') + 1) + '"') != std::string::npos);
  }
}

TEST_CASE("null takes an optional member away") {
  const Scene scene = scene_from_json(
      R"({"camera": {"height_m": null, "look_at": null}, "clouds": {"preset": "fair", "coverage": null}})", "s.json");
  CHECK_FALSE(scene.camera.height_m.has_value());
  CHECK_FALSE(scene.clouds.coverage.has_value());
  CHECK_FALSE(scene.camera.look_at.has_value());
}

TEST_CASE("a list of layers replaces the default one, and each layer starts from the defaults") {
  const Scene scene = scene_from_json(R"({"clouds": {"layers": [{"base_m": 900}, {}]}})", "s.json");
  REQUIRE(scene.clouds.layers.size() == 2);
  CHECK(scene.clouds.layers[0].base_m == 900.0);
  CHECK(scene.clouds.layers[0].thickness_m == CloudLayer{}.thickness_m);
  CHECK(scene.clouds.layers[1] == CloudLayer{});
}

TEST_CASE("an unknown key is an error with its path, the file and the nearest key") {
  CHECK(reading_fails(R"({"clouds": {"covrage": 0.5}})") ==
        "s.json: unknown key 'clouds.covrage'; did you mean 'coverage'?");
  CHECK(reading_fails(R"({"cluods": {}})") == "s.json: unknown key 'cluods'; did you mean 'clouds'?");
  CHECK(reading_fails(R"({"clouds": {"layers": [{}, {"bas_m": 1}]}})") ==
        "s.json: unknown key 'clouds.layers[1].bas_m'; did you mean 'base_m'?");
  CHECK(reading_fails(R"({"imagery": {"q": 1}})") == "s.json: unknown key 'imagery.q'; known here: files, bare_albedo");
}

TEST_CASE("a value out of its range is an error with path, value and range") {
  CHECK(reading_fails(R"({"clouds": {"coverage": 1.5}})") ==
        "s.json: clouds.coverage: 1.5 is out of range; allowed: 0..1");
  CHECK(reading_fails(R"({"camera": {"lat_deg": 91}})") ==
        "s.json: camera.lat_deg: 91 is out of range; allowed: -90..90 deg");
  CHECK(reading_fails(R"({"camera": {"fov_deg": 180}})") ==
        "s.json: camera.fov_deg: 180 is out of range; allowed: > 0 and < 180 deg");
  CHECK(reading_fails(R"({"render": {"width": 0}})") ==
        "s.json: render.width: 0 is out of range; allowed: 1..16384 px");
  CHECK(reading_fails(R"({"render": {"height": 100000}})") ==
        "s.json: render.height: 100000 is out of range; allowed: 1..16384 px");
  CHECK(reading_fails(R"({"render": {"seed": -1}})") ==
        "s.json: render.seed: -1 is out of range; allowed: 0..4294967295");
  CHECK(reading_fails(R"({"render": {"width": 18446744073709551617}})").starts_with("s.json: render.width: 1.8446744"));
  CHECK(reading_fails(R"({"atmosphere": {"rayleigh": {"scattering_per_m": [0, -1, 0]}}})") ==
        "s.json: atmosphere.rayleigh.scattering_per_m[1]: -1 is out of range; allowed: 0..1 1/m");
  CHECK(reading_fails(R"({"clouds": {"layers": [{}, {}, {}, {}, {}]}})") ==
        "s.json: clouds.layers: 5 items found; 4 at most");
  CHECK(reading_fails(R"({"render": {"quality": "hihg"}})") ==
        "s.json: render.quality: 'hihg' is not one of low, medium, high, ultra, reference; did you mean 'high'?");
}

TEST_CASE("a wrong type is an error with path, what is expected and what was found") {
  CHECK(reading_fails(R"({"clouds": {"coverage": "0.4"}})") ==
        "s.json: clouds.coverage: expected a number or null, found the string \"0.4\"");
  CHECK(reading_fails(R"({"clouds": []})") == "s.json: clouds: expected an object, found a list of 0");
  CHECK(reading_fails("[]") == "s.json: expected an object, found a list of 0");
  CHECK(reading_fails(R"({"camera": {"fov_deg": null}})") == "s.json: camera.fov_deg: expected a number, found null");
  CHECK(reading_fails(R"({"render": {"width": 1.5}})") == "s.json: render.width: expected a whole number, found 1.5");
  CHECK(reading_fails(R"({"terrain": {"elevation": "a.tif"}})") ==
        "s.json: terrain.elevation: expected a list, found the string \"a.tif\"");
  CHECK(reading_fails(R"({"terrain": {"elevation": [""]}})") ==
        "s.json: terrain.elevation[0].path: is empty; name a file");
  CHECK(reading_fails(R"({"terrain": {"default_earth": 1}})") ==
        "s.json: terrain.default_earth: expected true or false, found 1");
  CHECK(reading_fails(R"({"camera": {"look_at": 3}})") == "s.json: camera.look_at: expected an object, found 3");
  CHECK(reading_fails(R"({"atmosphere": {"ozone": {"absorption_per_m": [1, 2]}}})") ==
        "s.json: atmosphere.ozone.absorption_per_m: expected a list of 3 numbers, found a list of 2");
}

TEST_CASE("broken JSON is an error with line and column") {
  CHECK(reading_fails("{\n  \"clouds\": {\n    \"coverage\": 0.4,\n  }\n}")
            .starts_with("s.json: line 4, column 3: not JSON"));
  CHECK(reading_fails("").starts_with("s.json: line 1, column 1: not JSON"));
  CHECK(reading_fails("{\"clouds\": {\"coverage\": NaN}}").starts_with("s.json: line 1, column 25: not JSON"));
  CHECK(reading_fails("{} x").starts_with("s.json: line 1, column 4: not JSON"));
  CHECK(reading_fails("{\"clouds\": {\"coverage\": 1e999}}").starts_with("s.json: not JSON: "));
  CHECK(reading_fails(std::string("\x89PNG\r\n\x1a\n\0\xff", 10)).starts_with("s.json: line 1, column 1: not JSON"));
  CHECK(reading_fails("{\"time\": \"2026-01-01\", \"time\": \"2027-01-01\"}") ==
        "s.json: key 'time' occurs twice in one object");
}

TEST_CASE("members that contradict each other are an error") {
  CHECK(reading_fails(R"({"camera": {"height_m": 1, "agl_m": 2}})") ==
        "s.json: camera.agl_m: camera.height_m is given too; keep one of the two");
  CHECK(reading_fails(R"({"atmosphere": {"mie": {"extinction_per_m": [0, 0, 0]}}})") ==
        "s.json: atmosphere.mie.extinction_per_m[0]: 0 is less than scattering_per_m 1.8e-05");
  CHECK(reading_fails(R"({"render": {"min_ev100": 3, "max_ev100": 2}})") ==
        "s.json: render.min_ev100: 3 is larger than max_ev100 2");
}

TEST_CASE("validate names parameters as it is told and throws the kind it is told") {
  Scene scene;
  scene.clouds.coverage = std::numeric_limits<double>::quiet_NaN();
  try {
    validate(scene, ErrorKind::usage,
             [](const std::string& path) { return path == "clouds.coverage" ? "--coverage" : path; });
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::usage);
    CHECK(std::string(e.what()) == "--coverage: nan is out of range; allowed: 0..1");
  }
}

TEST_CASE("relative raster paths of a scene file are relative to the file, and saving keeps what they mean") {
  const fs::path dir = fs::temp_directory_path() / "nepho_scene_test";
  fs::remove_all(dir);
  fs::create_directories(dir / "in" / "dem");
  std::ofstream(dir / "in" / "s.json")
      << R"({"terrain": {"elevation": ["dem/a.tif", "/abs/b.tif", "../c.tif", "NETCDF:d.nc:v", "/vsizip/e.zip"]},
             "clouds": {"weather": {"source": "raster", "file": "w.png"},
                        "noise": {"shape": {"file": "dem/s.bin"}, "blue_noise_file": "/abs/b.bin"}}})";
  const Scene scene = load_scene(dir / "in" / "s.json");
  const std::vector<std::string> expected{dir / "in" / "dem" / "a.tif", "/abs/b.tif", dir / "c.tif", "NETCDF:d.nc:v",
                                          "/vsizip/e.zip"};
  std::vector<std::string> paths;
  for (const ElevationSource& source : scene.terrain.elevation) paths.push_back(source.path);
  CHECK(paths == expected);
  CHECK(scene.clouds.weather.file == (dir / "in" / "w.png").string());
  CHECK(scene.clouds.noise.shape.file == (dir / "in" / "dem" / "s.bin").string());
  CHECK(scene.clouds.noise.detail.file.empty());
  CHECK(scene.clouds.noise.blue_noise_file == "/abs/b.bin");
  CHECK(local_files(scene) == std::vector<std::string>{scene.clouds.weather.file, scene.clouds.noise.shape.file,
                                                       "/abs/b.bin", expected[0], expected[1], expected[2]});
  save_scene(dir / "in" / "saved.json", scene);
  CHECK(load_scene(dir / "in" / "saved.json") == scene);
  const std::string saved = read_text_file(dir / "in" / "saved.json");
  for (const char* relative : {"\"dem/a.tif\"", "\"w.png\"", "\"dem/s.bin\""})
    CHECK(saved.find(relative) != std::string::npos);
  fs::remove_all(dir);
}

TEST_CASE("a scene file that is missing is an input error that names it") {
  try {
    load_scene("/nonexistent/s.json");
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()) == "/nonexistent/s.json: no such file");
  }
}

TEST_CASE(
    "an atmosphere starts from its preset, whatever the order of the keys, and is saved as the values themselves") {
  const Scene demo = scene_from_json(R"({"atmosphere": {"ground_albedo": 0.25, "preset": "bruneton-demo"}})", "s.json");
  AtmosphereParams expected = AtmosphereParams::bruneton_demo();
  expected.ground_albedo = 0.25;
  CHECK(demo.atmosphere == expected);
  const std::string saved = scene_to_json(demo);
  CHECK(saved.find("preset") == std::string::npos);
  CHECK(scene_from_json(saved, "s.json") == demo);
  CHECK(scene_from_json(R"({"atmosphere": {"preset": "earth"}})", "s.json") == Scene{});
  Scene merged = demo;
  merge_scene_json(merged, R"({"atmosphere": {"top_height_m": 70000}})", "s.json");
  CHECK(merged.atmosphere.equatorial_radius_m == 6360000.0);
  merge_scene_json(merged, R"({"atmosphere": {"preset": "earth"}})", "s.json");
  CHECK(merged == Scene{});
  CHECK(reading_fails(R"({"atmosphere": {"preset": "brunton-demo"}})") ==
        "s.json: atmosphere.preset: 'brunton-demo' is not one of earth, bruneton-demo; did you mean 'bruneton-demo'?");
  CHECK(reading_fails(R"({"atmosphere": {"preset": 3}})") == "s.json: atmosphere.preset: expected a string, found 3");
  CHECK(reading_fails(R"({"atmosphere": {"prest": "earth"}})") ==
        "s.json: unknown key 'atmosphere.prest'; did you mean 'preset'?");
}

TEST_CASE("air that cannot be is an error that says which parameter and what is allowed") {
  const auto air_fails = [](const std::string& air) { return reading_fails(R"({"atmosphere": )" + air + "}"); };
  CHECK(air_fails(R"({"top_height_m": 7000})") ==
        "s.json: atmosphere.top_height_m: the air is too thin: 7000 m are less than 3 times rayleigh.scale_height_m "
        "8000; at least 24000 m");
  CHECK(air_fails(R"({"mie": {"scale_height_m": 40000}})").find("mie.scale_height_m 40000; at least 120000 m") !=
        std::string::npos);
  CHECK(air_fails(R"({"mie": {"scattering_per_m": [0, -1e-9, 0]}})") ==
        "s.json: atmosphere.mie.scattering_per_m[1]: -1e-09 is out of range; allowed: 0..1 1/m");
  CHECK(air_fails(R"({"ozone": {"absorption_per_m": [0, 0, -1]}})").find("absorption_per_m[2]: -1 is out of range") !=
        std::string::npos);
  CHECK(air_fails(R"({"rayleigh": {"scattering_per_m": [0.1, 0, 0]}})") ==
        "s.json: atmosphere.rayleigh.scattering_per_m[0]: gives the air a vertical optical depth of 800 at 680 nm; at "
        "most 100");
  CHECK(
      air_fails(R"({"mie": {"visibility_m": 10}})").starts_with("s.json: atmosphere.mie.visibility_m: gives the air"));
  CHECK(air_fails(R"({"ozone": {"column_du": -300}})") ==
        "s.json: atmosphere.ozone.column_du: -300 is out of range; allowed: 0..10000 DU");
  CHECK(air_fails(R"({"mie": {"optical_depth": 0.1, "visibility_m": 20000}})") ==
        "s.json: atmosphere.mie.visibility_m: mie.optical_depth is given too; keep one of the two");
  CHECK(air_fails(R"({"mie": {"visibility_m": 400000}})") ==
        "s.json: atmosphere.mie.visibility_m: 400000 m is more than gas alone allows; at most 288543 m");
  CHECK(air_fails(R"({"polar_radius_m": 6400000})").find("polar_radius_m: 6400000 is larger than") !=
        std::string::npos);
  CHECK(air_fails(R"({"scattering_orders": 51})").find("scattering_orders: 51 is out of range; allowed: 1..50") !=
        std::string::npos);
  CHECK(air_fails(R"({"mie": {"phase": "mie"}})").find("is not one of cornette-shanks, henyey-greenstein") !=
        std::string::npos);
}

TEST_CASE("a time outside the ephemeris' range is an error with the range") {
  for (const char* time : {"1899-12-31T23:59:59Z", "2101-01-01", "1900-01-01T00:00:00+09:00"}) {
    const std::string message = reading_fails(std::string(R"({"time": ")") + time + "\"}");
    CHECK(message.starts_with(std::string("s.json: time: time '") + time));
    CHECK(message.find("is outside 1900..2100") != std::string::npos);
  }
  CHECK_NOTHROW(scene_from_json(R"({"time": "1900-01-01"})", "s.json"));
  CHECK_NOTHROW(scene_from_json(R"({"time": "2100-12-31T23:59:59Z"})", "s.json"));
}
