#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "nepho/program.h"
#include "scene/places.h"
#include "scene/scene_json.h"

using namespace nepho;
namespace fs = std::filesystem;

namespace {

/// What a run of the command line did. Rendering is recorded instead of done: these tests are about the command line.
struct Run {
  int status = 0;
  std::string out, err;
  std::optional<Scene> scene;  ///< that would have been rendered
  RenderOutputs outputs;
  std::string probe_kind;
  std::optional<Scene> probe_scene;
};

Run run(std::vector<std::string> arguments) {
  Run result;
  std::istringstream in;
  std::ostringstream out, err;
  const Program program{.render =
                            [&](const Scene& scene, const RenderOutputs& outputs) {
                              result.scene = scene;
                              result.outputs = outputs;
                            },
                        .probe =
                            [&](const std::string& kind, std::istream&, std::ostream&, const ProbeOptions& options) {
                              result.probe_kind = kind;
                              result.probe_scene = options.scene;
                              return 0;
                            },
                        .info = [](bool as_json, std::ostream& stream) { stream << (as_json ? "{}" : "text"); },
                        .layer_names = {"depth", "position", "cloud", "variance", "samples", "sun.transmittance"},
                        .debug_views = {"weather", "density"},
                        .probe_kinds = {"geodetic_ecef"},
                        .in = in,
                        .out = out,
                        .err = err};
  result.status = run_program(arguments, program);
  result.out = out.str();
  result.err = err.str();
  return result;
}

/// A render command with an output in the temporary folder.
Run render(std::vector<std::string> options) {
  options.insert(options.begin(), "render");
  options.insert(options.end(), {"-o", fs::temp_directory_path() / "nepho_cli_test.png"});
  return run(options);
}

/// The scene that a render command with these options draws.
Scene scene_of(const std::vector<std::string>& options) {
  const Run result = render(options);
  CHECK(result.err.empty());
  CHECK(result.status == 0);
  REQUIRE(result.scene.has_value());
  return *result.scene;
}

/// Checks that a command fails with a status and one line on standard error, which is returned without its prefix.
std::string message_of(const Run& result, int status) {
  CHECK(result.status == status);
  CHECK(result.out.empty());
  CHECK_FALSE(result.scene.has_value());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  const std::string prefix = "nepho: error: ";
  CHECK(result.err.starts_with(prefix));
  return result.err.substr(std::min(prefix.size(), result.err.size()), result.err.find('\n') - prefix.size());
}

}  // namespace

TEST_CASE("--help and --version go to standard output with status 0") {
  CHECK(run({"--version"}).out == "nepho " NEPHO_VERSION "\n");
  const Run help = run({"--help"});
  CHECK(help.status == 0);
  for (const char* command : {"render", "probe", "info", "compare", "tour", "bench", "map", "view"})
    CHECK(help.out.find(std::string("  ") + command + " ") != std::string::npos);
  const Run render_help = run({"render", "--help"});
  CHECK(render_help.status == 0);
  for (const char* option : {"--place",      "--at",           "--height",       "--agl",
                             "--heading",    "--pitch",        "--roll",         "--look-at",
                             "--fov",        "--time",         "--size",         "--quality",
                             "--upscale",    "--coverage",     "--terrain",      "--imagery",
                             "--weather",    "--weather-tile", "--weather-seed", "--sky",
                             "--frames",     "--seed",         "--exposure",     "--aov",
                             "--debug",      "--timings",      "--device",       "--save-scene",
                             "--atmosphere", "--orders",       "--spectral",     "--aerosol-optical-depth",
                             "--visibility", "--ozone-du"})
    CHECK_MESSAGE(render_help.out.find(option) != std::string::npos, option);
  CHECK(render_help.out.find("--validation") == std::string::npos);
}

TEST_CASE("commands of later issues say 'not supported yet' in one line, status 2") {
  CHECK(run({"tour", "a.kml", "-o", "b.mp4"}).err == "nepho tour: not supported yet\n");
  for (const char* command : {"tour", "map", "view"}) CHECK(run({command}).status == 2);
}

TEST_CASE("a missing or unknown command or option is a usage error that says what was meant") {
  CHECK(message_of(run({}), 2) == "a command is missing; see nepho --help");
  CHECK(message_of(run({"rendr"}), 2) == "'rendr' is not expected; did you mean 'render'?");
  CHECK(message_of(render({"--covrage", "0.2"}), 2) == "'--covrage' is not expected; did you mean '--coverage'?");
  CHECK(message_of(run({"render", "--fov"}), 2).find("--fov") != std::string::npos);
  CHECK(message_of(run({"probe"}), 2).find("kind") != std::string::npos);
}

TEST_CASE("the options of the issue's example give the scene that they say") {
  const Scene scene = scene_of({"--at", "35.47,138.60", "--height", "2500", "--look-at", "35.3606,138.7274,3700",
                                "--time", "2026-06-20T23:30:00Z", "--size", "641x361"});
  CHECK(scene.camera.lat_deg == 35.47);
  CHECK(scene.camera.lon_deg == 138.60);
  CHECK(scene.camera.height_m == 2500.0);
  CHECK(scene.camera.look_at == LookAt{.lat_deg = 35.3606, .lon_deg = 138.7274, .height_m = 3700.0});
  CHECK(scene.time == "2026-06-20T23:30:00Z");
  CHECK(scene.render.width == 641);
  CHECK(scene.render.height == 361);
}

TEST_CASE("--strict and --incomplete-ok are handed on, and are off without being asked for") {
  const Run plain = render({}), both = render({"--strict", "--incomplete-ok"});
  CHECK_FALSE(plain.outputs.strict);
  CHECK_FALSE(plain.outputs.incomplete_ok);
  CHECK(both.outputs.strict);
  CHECK(both.outputs.incomplete_ok);
}

TEST_CASE("every option of one number or name sets its parameter") {
  const Scene scene = scene_of({"--agl",    "12.5",  "--heading", "270",        "--pitch",    "-30",        "--roll",
                                "-5",       "--fov", "60",        "--quality",  "low",        "--coverage", "0.7",
                                "--frames", "3",     "--seed",    "4294967295", "--exposure", "-2.5"});
  CHECK(scene.camera.agl_m == 12.5);
  CHECK_FALSE(scene.camera.height_m.has_value());
  CHECK(scene.camera.heading_deg == 270.0);
  CHECK(scene.camera.pitch_deg == -30.0);
  CHECK(scene.camera.roll_deg == -5.0);
  CHECK(scene.camera.fov_deg == 60.0);
  CHECK(scene.render.quality == "low");
  CHECK(scene.clouds.coverage == 0.7);
  CHECK(scene.render.frames == 3);
  CHECK(scene.render.seed == 4294967295u);
  CHECK(scene.render.exposure_ev100 == -2.5);
  CHECK_FALSE(scene_of({"--exposure", "auto"}).render.exposure_ev100.has_value());
}

TEST_CASE("the options of the air change the scene's, or that of a preset") {
  const AtmosphereParams air =
      scene_of({"--orders", "3", "--spectral", "fast", "--aerosol-optical-depth", "0.2", "--ozone-du", "250"})
          .atmosphere;
  AtmosphereParams expected;
  expected.scattering_orders = 3;
  expected.spectral = "fast";
  expected.mie.optical_depth = 0.2;
  expected.ozone.column_du = 250.0;
  CHECK(air == expected);
  CHECK(scene_of({"--visibility", "20000"}).atmosphere.mie.visibility_m == 20000.0);

  const fs::path file = fs::temp_directory_path() / "nepho_cli_air.json";
  std::ofstream(file) << R"({"atmosphere": {"ground_albedo": 0.5, "mie": {"optical_depth": 0.1}}})";
  AtmosphereParams demo = AtmosphereParams::bruneton_demo();
  CHECK(scene_of({file, "--atmosphere", "bruneton-demo"}).atmosphere == demo);
  demo.scattering_orders = 2;
  CHECK(scene_of({file, "--orders", "2", "--atmosphere", "bruneton-demo"}).atmosphere == demo);
  const AtmosphereParams hazy = scene_of({file, "--visibility", "9000"}).atmosphere;
  CHECK(hazy.ground_albedo == 0.5);
  CHECK(hazy.mie.visibility_m == 9000.0);
  CHECK_FALSE(hazy.mie.optical_depth.has_value());
  std::ofstream(file) << R"({"atmosphere": {"mie": {"visibility_m": 5000}}})";
  CHECK_FALSE(scene_of({file, "--aerosol-optical-depth", "0.3"}).atmosphere.mie.visibility_m.has_value());
  fs::remove(file);
  CHECK(run({"probe", "geodetic_ecef", "--atmosphere", "bruneton-demo", "--orders", "2"}).probe_scene->atmosphere ==
        demo);
}

TEST_CASE("--sky replaces the scene's clouds, and the other options of clouds change what it or the scene has") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_clouds.json";
  std::ofstream(file) << R"({"clouds": {"coverage": 0.9, "scattering_per_m": 0.1, "layers": [{"base_m": 777}]}})";
  CHECK(scene_of({}).clouds == cloud_sky("earth"));
  CHECK(scene_of({file, "--sky", "storm"}).clouds == cloud_sky("storm"));
  CHECK(scene_of({"--sky", "cirrus"}).clouds.layers == std::vector<CloudLayer>{*cloud_genus("cirrus")});
  CloudParams fair = cloud_sky("fair").value();
  fair.coverage = 0.75;
  fair.weather.seed = 99;
  CHECK(scene_of({"--coverage", "0.75", "--weather-seed", "99", "--sky", "fair"}).clouds == fair);
  const CloudParams covered = scene_of({file, "--coverage", "0"}).clouds;
  CHECK(covered.coverage == 0.0);
  CHECK(covered.layers[0].base_m == 777.0);
  CHECK(message_of(render({"--sky", "stormy"}), 2)
            .ends_with("valley-fog, stratus, stratocumulus, cumulus, altocumulus, cirrus, cumulonimbus, fog; did you "
                       "mean 'storm'?"));
  CHECK(message_of(render({"--weather-seed", "-1"}), 2) ==
        "--weather-seed: -1 is out of range; allowed: 0..4294967295");
  fs::remove(file);
  CHECK(run({"probe", "geodetic_ecef", "--sky", "fair"}).probe_scene->clouds == cloud_sky("fair"));
}

TEST_CASE("--weather and --weather-tile take the weather from a file, and unset a uniform coverage") {
  const CloudParams raster = scene_of({"--sky", "fair", "--weather", NEPHO_SOURCE_DIR "/LICENSE"}).clouds;
  CHECK(raster.weather.source == "raster");
  CHECK(raster.weather.file == NEPHO_SOURCE_DIR "/LICENSE");
  CHECK_FALSE(raster.coverage.has_value());
  CHECK(raster.layers == cloud_sky("fair")->layers);
  const CloudParams tile = scene_of({"--weather-tile", NEPHO_SOURCE_DIR "/LICENSE"}).clouds;
  CHECK(tile.weather.source == "tile");
  CHECK(tile.weather.file == NEPHO_SOURCE_DIR "/LICENSE");
  CHECK(scene_of({"--weather", "NETCDF:a.nc:cover"}).clouds.weather.file == "NETCDF:a.nc:cover");
  CHECK(message_of(render({"--weather", "/nonexistent/a.tif"}), 3) == "/nonexistent/a.tif: no such file");
  CHECK(message_of(render({"--weather-tile", "/nonexistent/a.png"}), 3) == "/nonexistent/a.png: no such file");
  CHECK(message_of(render({"--weather", ""}), 2) == "--weather: the name of the file is empty");
  CHECK(message_of(render({"--weather", "a.tif", "--coverage", "0.5"}), 2) ==
        "--weather and --coverage: give one of the two");
  CHECK(message_of(render({"--weather", "a.tif", "--weather-tile", "b.png"}), 2) ==
        "--weather and --weather-tile: give one of the two");
  CHECK(message_of(render({"--weather-tile", "b.png", "--coverage", "0.5"}), 2) ==
        "--weather-tile and --coverage: give one of the two");
}

TEST_CASE("clouds in a scene file that cannot be are status 3 in one line, for pictures and probes alike") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_bad_clouds.json";
  const struct {
    const char *json, *says;
  } cases[] = {{R"({"layers": [{}, {}, {}, {}, {}]})", "clouds.layers: 5 items found; 4 at most"},
               {R"({"layers": [{"thickness_m": -1}]})", "clouds.layers[0].thickness_m: -1 is out of range"},
               {R"({"layers": [{"base_m": NaN}]})", "not JSON"},
               {R"({"layers": [{"base_m": 1e400}]})", "not JSON"},
               {R"({"layers": [{"base_m": 2000, "top_m": 1000}]})", "unknown key 'clouds.layers[0].top_m'"},
               {R"({"layers": [{"density_profile": {"linear_term": -1, "constant_term": 0}}]})", "nowhere above 0"},
               {R"({"preset": "fare"})", "did you mean 'fair'?"},
               {R"({"weather": {"source": "raster"}})", "source raster needs a file"},
               {R"({"weather": {"file": "a.png"}})", "is not looked at by source procedural"},
               {R"({"weather": {"source": "raster", "file": "gone.png"}})", "gone.png: no such file"},
               {R"({"noise": {"shape": {"file": "gone.bin"}}})", "gone.bin: no such file"},
               {R"({"noise": {"blue_noise_file": "gone.bin"}})", "gone.bin: no such file"}};
  for (const auto& c : cases) {
    std::ofstream(file) << R"({"clouds": )" << c.json << "}";
    CAPTURE(c.json);
    for (const Run& failed : {render({file}), run({"probe", "geodetic_ecef", file})}) {
      const std::string message = message_of(failed, 3);
      CHECK(message.starts_with(file.parent_path().string()));
      CHECK_MESSAGE(message.find(c.says) != std::string::npos, message);
      CHECK_FALSE(failed.probe_scene.has_value());
    }
  }
  fs::remove(file);
}

TEST_CASE("--debug takes the name of a view; others are usage errors with the known ones") {
  CHECK(render({"--debug", "density"}).outputs.debug == "density");
  CHECK(render({}).outputs.debug.empty());
  CHECK(message_of(render({"--debug", "densty"}), 2) ==
        "--debug: 'densty' is not one of weather, density; did you mean 'density'?");
  CHECK(message_of(run({"render", "--debug", "weather", "-o", "a.exr"}), 2) ==
        "--debug: false colours are written as .png only; give -o OUT.png");
}

TEST_CASE("air that cannot be is a usage error that names the option") {
  CHECK(message_of(render({"--atmosphere", "brunton-demo"}), 2) ==
        "--atmosphere: 'brunton-demo' is not one of earth, bruneton-demo; did you mean 'bruneton-demo'?");
  CHECK(message_of(render({"--visibility", "1000", "--aerosol-optical-depth", "1"}), 2) ==
        "--aerosol-optical-depth and --visibility: give one of the two");
  CHECK(message_of(render({"--visibility", "300000"}), 2) ==
        "--visibility: 300000 m is more than gas alone allows; at most 288543 m");
  CHECK(message_of(render({"--visibility", "nan"}), 2).starts_with("--visibility: nan is out of range"));
  CHECK(message_of(render({"--aerosol-optical-depth", "-0.1"}), 2) ==
        "--aerosol-optical-depth: -0.1 is out of range; allowed: 0..100");
  CHECK(
      message_of(render({"--aerosol-optical-depth", "100"}), 2).starts_with("--aerosol-optical-depth: gives the air"));
  CHECK(message_of(render({"--ozone-du", "inf"}), 2) == "--ozone-du: inf is out of range; allowed: 0..10000 DU");
  CHECK(message_of(render({"--orders", "0"}), 2) == "--orders: 0 is out of range; allowed: 1..50");
  CHECK(message_of(render({"--orders", "2.5"}), 2) == "--orders: 2.5 is not a whole number");
  CHECK(message_of(render({"--spectral", "slow"}), 2) == "--spectral: 'slow' is not one of fast, full");
}

TEST_CASE("of an option given twice the last one counts") {
  CHECK(scene_of({"--size", "1x1", "--size", "4x3"}).render.width == 4);
}

TEST_CASE("negative numbers parse as values of options") {
  const Scene scene = scene_of({"--at", "-33.8,151.2", "--look-at", "-33.9,-151.2"});
  CHECK(scene.camera.lat_deg == -33.8);
  CHECK(scene.camera.look_at->lon_deg == -151.2);
  CHECK(scene_of({"--pitch", "-30"}).camera.pitch_deg == -30.0);
  CHECK(scene_of({"--at=-33.8,-151.2"}).camera.lon_deg == -151.2);
}

TEST_CASE("--at alone stands 2 m above the ground, whatever the scene file says of its own place") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_test.json";
  std::ofstream(file) << R"({"camera": {"height_m": 9000, "look_at": {"lat_deg": 1, "lon_deg": 2}, "fov_deg": 33},
                             "clouds": {"coverage": 0.9}})";
  const Scene scene = scene_of({file, "--at", "10,20"});
  CHECK_FALSE(scene.camera.height_m.has_value());
  CHECK_FALSE(scene.camera.agl_m.has_value());
  CHECK_FALSE(scene.camera.look_at.has_value());
  CHECK(scene.camera.fov_deg == 33.0);
  CHECK(scene.clouds.coverage == 0.9);
  CHECK(scene_of({file, "--agl", "5"}).camera.agl_m == 5.0);
  CHECK(scene_of({file, "--coverage", "0.1"}).camera.height_m == 9000.0);
  fs::remove(file);
}

TEST_CASE("without a scene, place or point the view is that of fuji; a place brings its camera and time") {
  const Place fuji = find_place("fuji");
  CHECK(scene_of({}).camera == fuji.camera);
  CHECK(scene_of({}).time == fuji.time);
  CHECK(scene_of({"--place", "orbit"}).camera.height_m == 400e3);
  CHECK(scene_of({"--place", "orbit", "--time", "2026-01-01T12:00+01:00"}).time == "2026-01-01T11:00:00Z");
  CHECK(scene_of({"--at", "1,2"}).camera.heading_deg == 0.0);
}

TEST_CASE("a heading or pitch takes the place of a scene's look_at") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_test2.json";
  std::ofstream(file) << R"({"camera": {"look_at": {"lat_deg": 1, "lon_deg": 2}}})";
  CHECK_FALSE(scene_of({file, "--heading", "90"}).camera.look_at.has_value());
  fs::remove(file);
}

TEST_CASE("options that exclude each other are usage errors") {
  CHECK(message_of(render({"--place", "fuji", "--at", "1,2"}), 2) == "--place and --at: give one of the two");
  CHECK(message_of(render({"--height", "1", "--agl", "2"}), 2) == "--height and --agl: give one of the two");
  CHECK(message_of(render({"--look-at", "1,2", "--pitch", "2"}), 2) == "--look-at and --pitch: give one of the two");
}

TEST_CASE("values out of range are usage errors that name the option and the range") {
  CHECK(message_of(render({"--at", "91,0"}), 2) == "--at: lat: 91 is out of range; allowed: -90..90 deg");
  CHECK(message_of(render({"--look-at", "0,500"}), 2) == "--look-at: lon: 500 is out of range; allowed: -180..360 deg");
  CHECK(message_of(render({"--size", "0x0"}), 2) == "--size: width: 0 is out of range; allowed: 1..16384 px");
  CHECK(message_of(render({"--size", "100000x100000"}), 2) ==
        "--size: width: 100000 is out of range; allowed: 1..16384 px");
  CHECK(message_of(render({"--size", "640x-360"}), 2) == "--size: height: -360 is out of range; allowed: 1..16384 px");
  CHECK(message_of(render({"--coverage", "1.01"}), 2) == "--coverage: 1.01 is out of range; allowed: 0..1");
  CHECK(message_of(render({"--coverage", "nan"}), 2) == "--coverage: nan is out of range; allowed: 0..1");
  CHECK(message_of(render({"--fov", "0"}), 2) == "--fov: 0 is out of range; allowed: > 0 and < 180 deg");
  CHECK(message_of(render({"--height", "inf"}), 2) == "--height: inf is out of range; allowed: -12000..1000000000 m");
  CHECK(message_of(render({"--frames", "0"}), 2) == "--frames: 0 is out of range; allowed: 1..16777216");
  CHECK(message_of(render({"--exposure", "100"}), 2) == "--exposure: 100 is out of range; allowed: -30..40 EV");
  CHECK(message_of(render({"--time", "1850-01-01"}), 2).starts_with("--time: time '1850-01-01'"));
  CHECK(message_of(render({"--quality", "best"}), 2).starts_with("--quality: 'best' is not one of low, medium,"));
}

TEST_CASE("values that are not what the option wants are usage errors that quote them") {
  CHECK(message_of(render({"--fov", "wide"}), 2) == "--fov: 'wide' is not a number");
  CHECK(message_of(render({"--fov", "45deg"}), 2) == "--fov: '45deg' is not a number");
  CHECK(message_of(render({"--at", "35.47"}), 2) == "--at: '35.47' is not LAT,LON");
  CHECK(message_of(render({"--at", "35,138,2"}), 2) == "--at: '35,138,2' is not LAT,LON");
  CHECK(message_of(render({"--look-at", "35,x"}), 2) == "--look-at: 'x' is not a number");
  CHECK(message_of(render({"--size", "640"}), 2) == "--size: '640' is not WxH, such as 640x360");
  CHECK(message_of(render({"--size", "640.5x360"}), 2) == "--size: width: 640.5 is not a whole number");
  CHECK(message_of(render({"--coverage", "1e999"}), 2) == "--coverage: 1e999 is too large or too small for a number");
  CHECK(message_of(render({"--place", "fugi"}), 2).starts_with("--place: 'fugi' is unknown; did you mean 'fuji'?"));
}

TEST_CASE("clouds are upscaled by 16, 4, 2 or 1") {
  CHECK(message_of(render({"--upscale", "3"}), 2) == "--upscale: 3 is not one of 1, 2, 4, 16");
  CHECK(message_of(render({"--upscale", "0"}), 2).starts_with("--upscale: 0 is out of range"));
  for (const char* upscale : {"1", "2", "4", "16"}) CHECK(render({"--upscale", upscale}).status == 0);
}

TEST_CASE("a benchmark of scenes, sizes, qualities and upscalings measures every combination") {
  std::vector<BenchCase> cases;
  uint32_t frames = 0;
  const auto bench = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "bench");
    std::istringstream in;
    std::ostringstream out, err;
    const Program program{.bench =
                              [&](const BenchRequest& request, std::ostream&) {
                                cases = request.cases;
                                frames = request.frames;
                                return std::vector<BenchResult>(request.cases.size());
                              },
                          .in = in,
                          .out = out,
                          .err = err};
    const int status = run_program(arguments, program);
    return std::pair(status, err.str());
  };
  CHECK(bench({}).first == 0);
  REQUIRE(cases.size() == 1);
  CHECK(cases[0].name == "ground");
  CHECK(cases[0].scene.render.width == 640);
  CHECK(bench({"--scene", "all"}).first == 0);
  CHECK(cases.size() == 10);
  CHECK(cases.back().name == "fly-through");
  CHECK(cases.back().speed_mps == 250.0);
  CHECK(bench({"--scene", "clear", "--scene", "10km", "--size", "64x36", "--size", "128x72", "--quality", "low",
               "--upscale", "16", "--upscale", "1", "--frames", "3", "--turn", "90"})
            .first == 0);
  REQUIRE(cases.size() == 8);
  CHECK(frames == 3);
  CHECK(cases[1].scene.render.upscale == 1);
  CHECK(cases[2].scene.render.height == 72);
  CHECK(cases[7].name == "10km");
  CHECK(cases[7].scene.render.quality == "low");
  CHECK(cases[7].turn_deg_s == 90.0);
  CHECK(bench({"--pictures", "/no/such/folder"}).first == 2);
  CHECK(bench({"--pictures", "/no/such/folder"}).second.find("--pictures: /no/such/folder: no such folder") !=
        std::string::npos);
  CHECK(bench({"--scene", "grund"}).first == 2);
  CHECK(bench({"--scene", "grund"}).second.find("did you mean 'ground'?") != std::string::npos);
  CHECK(bench({"--scene", "none.json"}).first == 3);
  CHECK(bench({"--size", "64"}).first == 2);
  CHECK(bench({"--upscale", "8"}).first == 2);
  CHECK(bench({"--frames", "0"}).first == 2);
  CHECK(bench({"--quality", "reference"}).first == 2);
}

TEST_CASE("--quality reference ends at the noise or the paths that are asked for, by itself at a noise of 0.02") {
  const RenderParams alone = scene_of({"--quality", "reference"}).render;
  CHECK(alone.quality == "reference");
  CHECK(alone.noise == 0.02);
  const RenderParams frames = scene_of({"--quality", "reference", "--frames", "1"}).render;
  CHECK(frames.noise == 0.0);
  CHECK(frames.frames == 1);
  CHECK(scene_of({"--quality", "reference", "--noise", "0.1"}).render.noise == 0.1);
  const RenderParams both = scene_of({"--quality", "reference", "--noise", "0.1", "--frames", "300"}).render;
  CHECK(both.noise == 0.1);
  CHECK(both.frames == 300);
  CHECK(scene_of({}).render.noise == 0.0);
  CHECK(render({"--quality", "reference", "--aov", "variance,samples"}).outputs.layers ==
        std::set<std::string>{"samples", "variance"});
  CHECK(render({"--quality", "reference", "--resume", "/dev/null"}).outputs.resume == "/dev/null");
}

TEST_CASE("what belongs to --quality reference alone, or does not go with it, is a usage error") {
  CHECK(message_of(render({"--noise", "0.1"}), 2) ==
        "--noise: the quality is medium; it stops --quality reference only");
  CHECK(message_of(render({"--resume", "/dev/null"}), 2) ==
        "--resume: the quality is medium; only --quality reference can go on");
  CHECK(message_of(render({"--quality", "reference", "--resume", "/nonexistent/a.exr"}), 3) ==
        "/nonexistent/a.exr: no such file");
  CHECK(message_of(render({"--aov", "variance"}), 2) == "--aov variance: written by --quality reference only");
  CHECK(message_of(render({"--aov", "depth,samples"}), 2) == "--aov samples: written by --quality reference only");
  CHECK(message_of(render({"--quality", "reference", "--aov", "sun.transmittance"}), 2) ==
        "--aov sun.transmittance: comes from shadow maps, which --quality reference does not use");
  CHECK(message_of(render({"--quality", "reference", "--debug", "weather"}), 2) ==
        "--debug weather: shows the march, which --quality reference does not use");
  CHECK(message_of(render({"--quality", "reference", "--noise", "nan"}), 2).starts_with("--noise: nan is out of"));
}

TEST_CASE("outputs: several, of known kinds, in folders that exist") {
  const fs::path dir = fs::temp_directory_path();
  const Run both = run({"render", "-o", dir / "a.exr", "-o", dir / "b.PNG", "--timings", dir / "t.json", "--device",
                        "llvm", "--validation", "--aov", "depth,cloud"});
  CHECK(both.status == 0);
  CHECK(both.outputs.images == std::vector<fs::path>{dir / "a.exr", dir / "b.PNG"});
  CHECK(both.outputs.timings == dir / "t.json");
  CHECK(both.outputs.device == "llvm");
  CHECK(both.outputs.validation);
  CHECK(both.outputs.layers == std::set<std::string>{"cloud", "depth"});
  CHECK(render({}).outputs.layers.empty());
  CHECK(message_of(run({"render"}), 2).starts_with("no output: give -o OUT.png"));
  CHECK(message_of(run({"render", "-o", "a.jpg"}), 2) == "-o: 'a.jpg' does not end in .exr or .png");
  CHECK(
      message_of(run({"render", "-o", "/nonexistent/a.png"}), 5).starts_with("/nonexistent/a.png: cannot be written"));
  CHECK(message_of(render({"--timings", "/nonexistent/t.json"}), 5).starts_with("/nonexistent/t.json: "));
  CHECK(message_of(render({"--aov", "dept"}), 2) ==
        "--aov: 'dept' is unknown; did you mean 'depth'? known: depth, position, cloud, variance, samples, "
        "sun.transmittance");
}

TEST_CASE("a missing or wrong input file is status 3, before the device is opened") {
  CHECK(message_of(render({"/nonexistent/s.json"}), 3) == "/nonexistent/s.json: no such file");
  CHECK(message_of(render({"--terrain", "/nonexistent/a.tif"}), 3) == "/nonexistent/a.tif: no such file");
  CHECK(message_of(render({"--imagery", "/nonexistent/a.tif"}), 3) == "/nonexistent/a.tif: no such file");
  const fs::path file = fs::temp_directory_path() / "nepho_cli_test3.json";
  std::ofstream(file) << R"({"camera": {"lat_deg": 91}})";
  CHECK(message_of(render({file}), 3) == file.string() + ": camera.lat_deg: 91 is out of range; allowed: -90..90 deg");
  std::ofstream(file) << R"({"terrain": {"elevation": ["gone.tif"]}})";
  CHECK(message_of(render({file}), 3) == (file.parent_path() / "gone.tif").string() + ": no such file");
  fs::remove(file);
}

TEST_CASE("air in a scene file that cannot be is status 3 in one line, for pictures and probes alike") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_bad_air.json";
  const struct {
    const char *json, *says;
  } cases[] = {
      {R"({"atmosphere": {"top_height_m": 5000}})", "atmosphere.top_height_m: the air is too thin"},
      {R"({"atmosphere": {"rayleigh": {"scale_height_m": 50000}}})", "too thin"},
      {R"({"atmosphere": {"rayleigh": {"scale_height_m": 0}}})", "atmosphere.rayleigh.scale_height_m: 0 is out of"},
      {R"({"atmosphere": {"rayleigh": {"scattering_per_m": [-1e-6, 0, 0]}}})", "scattering_per_m[0]: -1e-06 is out of"},
      {R"({"atmosphere": {"mie": {"extinction_per_m": [1, 1, 1]}}})", "a vertical optical depth of"},
      {R"({"atmosphere": {"mie": {"phase_g": 1.5}}})", "atmosphere.mie.phase_g: 1.5 is out of range"},
      {R"({"atmosphere": {"ozone": {"half_width_m": NaN}}})", ""},
      {R"({"atmosphere": {"ground_albedo": 1e300}})", "atmosphere.ground_albedo: 1e+300 is out of range"},
      {R"({"atmosphere": {"scattering_orders": 2.5}})", "atmosphere.scattering_orders"},
      {R"({"time": "2150-01-01T00:00:00Z"})", "time"},
      {R"({"time": "1899-12-31T23:59:59Z"})", "time"}};
  for (const auto& c : cases) {
    std::ofstream(file) << c.json;
    CAPTURE(c.json);
    for (const Run& failed : {render({file}), run({"probe", "geodetic_ecef", file})}) {
      const std::string message = message_of(failed, 3);
      CHECK(message.starts_with(file.string()));
      CHECK_MESSAGE(message.find(c.says) != std::string::npos, message);
      CHECK_FALSE(failed.probe_scene.has_value());
    }
  }
  fs::remove(file);
  CHECK(message_of(render({"--time", "2101-01-01"}), 2).starts_with("--time: "));
  CHECK(message_of(run({"probe", "geodetic_ecef", "--visibility", "-5"}), 2).starts_with("--visibility: -5"));
  CHECK(message_of(run({"probe", "geodetic_ecef", "--orders", "nan"}), 2).starts_with("--orders: "));
}

TEST_CASE("--terrain and --imagery take one file each time and add to those of the scene") {
  const Scene scene = scene_of({"--terrain", "/etc", "--terrain", "/vsizip/a.zip,opacity=0.5,vertical_scale=2",
                                "--imagery", "NETCDF:a.nc:v", "--imagery", "/etc/{z}/{x}/{y}.png,gamma=1.5"});
  CHECK(
      scene.terrain.elevation ==
      std::vector<ElevationSource>{{.path = "/etc"}, {.path = "/vsizip/a.zip", .opacity = 0.5, .vertical_scale = 2.0}});
  CHECK(scene.imagery.files ==
        std::vector<ImagerySource>{{.path = "NETCDF:a.nc:v"}, {.path = "/etc/{z}/{x}/{y}.png", .gamma = 1.5}});
  CHECK(message_of(render({"--terrain", "/etc,opacity=2"}), 2) ==
        "--terrain: opacity: 2 is out of range; allowed: 0..1");
  CHECK(message_of(render({"--imagery", "/etc,gama=2"}), 2) ==
        "--imagery: unknown key 'gama' in '/etc,gama=2'; did you mean 'gamma'?");
  CHECK(message_of(render({"--imagery", "/nonexistent/{z}/{x}/{y}.png"}), 3) ==
        "/nonexistent/{z}/{x}/{y}.png: no such file, and no such folder of tiles");
  CHECK(message_of(render({"--imagery", "/dev/zero"}), 3) == "/dev/zero: is a pipe or device; give a file");
}

TEST_CASE("the options of streaming, water and collision set the scene's parameters") {
  const Scene scene = scene_of({"--host-budget", "300", "--gpu-budget", "200", "--disk-cache", "0", "--water-mask",
                                NEPHO_SOURCE_DIR "/LICENSE", "--allow-underground"});
  CHECK(scene.terrain.host_budget_mb == 300);
  CHECK(scene.terrain.gpu_budget_mb == 200);
  CHECK(scene.terrain.disk_cache_mb == 0);
  CHECK(scene.terrain.water_mask == NEPHO_SOURCE_DIR "/LICENSE");
  CHECK(scene.camera.allow_underground);
  CHECK_FALSE(scene_of({}).camera.allow_underground);
  CHECK(message_of(render({"--host-budget", "0"}), 2) == "--host-budget: 0 is out of range; allowed: 1..1048576 MiB");
  CHECK(message_of(render({"--water-mask", "/nonexistent/w.tif"}), 3) == "/nonexistent/w.tif: no such file");
}

TEST_CASE("--save-scene writes the scene as drawn, and needs no picture") {
  const fs::path file = fs::temp_directory_path() / "nepho_cli_saved.json";
  const Run saved = run({"render", "--place", "london", "--coverage", "0.25", "--save-scene", file});
  CHECK(saved.status == 0);
  CHECK_FALSE(saved.scene.has_value());
  CHECK(scene_of({file}) == scene_of({"--place", "london", "--coverage", "0.25"}));
  fs::remove(file);
}

TEST_CASE("probe takes a kind and the options of a scene; info takes --json") {
  const Run probe = run({"probe", "geodetic_ecef", "--coverage", "0.2"});
  CHECK(probe.status == 0);
  CHECK(probe.probe_kind == "geodetic_ecef");
  CHECK(probe.probe_scene->clouds.coverage == 0.2);
  CHECK(message_of(run({"probe", "geodetic_ecef", "--coverage", "2"}), 2).starts_with("--coverage: 2 is out of range"));
  CHECK(run({"info"}).out == "text");
  CHECK(run({"info", "--json"}).out == "{}");
}

TEST_CASE("a failure in the middle of the work is status 5 in one line") {
  std::istringstream in;
  std::ostringstream out, err;
  const Program program{.render = [](const Scene&, const RenderOutputs&) { throw std::runtime_error("broken\npipe"); },
                        .in = in,
                        .out = out,
                        .err = err};
  CHECK(run_program({"render", "-o", fs::temp_directory_path() / "x.png"}, program) == 5);
  CHECK(err.str() == "nepho: error: broken pipe\n");
}
