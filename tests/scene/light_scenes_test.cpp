#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "astro/sky_bodies.h"
#include "base/files.h"
#include "scene/scene_json.h"

using namespace nepho;

namespace {

const std::array kLightScenes{
    "cumulus_sun60",  "cumulus_sun30",     "cumulus_sun5",       "cumulus_backlit",     "cumulus_from_below",
    "cumulus_inside", "cumulus_from_10km", "cumulus_from_400km", "overcast_from_below", "overcast_from_above",
    "cirrus",         "cumulonimbus",      "mixed_layers"};

std::filesystem::path path_of(const std::string& name) { return data_dir() / "scenes" / (name + ".json"); }

Horizontal sun_of(const Scene& scene) {
  const Geodetic observer =
      Geodetic::from_degrees(scene.camera.lat_deg, scene.camera.lon_deg, scene.camera.height_m.value());
  const SunState sun = sky_bodies_at(parse_utc(scene.time)).sun;
  return horizontal_from_ecef(observer, sun.dir_ecef, sun.distance_au * kAstronomicalUnit_m);
}

}  // namespace

TEST_CASE("the scenes that measure light need no file and nothing installed, and are 256 x 144") {
  for (const char* name : kLightScenes) {
    CAPTURE(name);
    const Scene scene = load_scene(path_of(name));
    CHECK(local_files(scene).empty());
    CHECK(scene.terrain.elevation.empty());
    CHECK(scene.imagery.files.empty());
    CHECK_FALSE(scene.terrain.default_earth);
    CHECK_FALSE(scene.night_sky.stars);
    CHECK_FALSE(scene.night_sky.moon);
    CHECK(scene.clouds.weather.source == "procedural");
    CHECK(scene.clouds.coverage.has_value());  // and so no weather map
    CHECK(scene.camera.height_m.has_value());
    CHECK_FALSE(scene.camera.look_at.has_value());
    CHECK(scene.render.exposure_ev100.has_value());
    CHECK(scene.render.quality == "high");
    CHECK(scene.render.width == 256);
    CHECK(scene.render.height == 144);
    REQUIRE_FALSE(scene.clouds.layers.empty());
    for (const CloudLayer& layer : scene.clouds.layers) CHECK(layer.base_reference == "ellipsoid");
  }
}

TEST_CASE("the scenes that measure light name no preset, so that a preset may change and they do not") {
  for (const char* name : kLightScenes) {
    CAPTURE(name);
    std::ifstream in(path_of(name));
    std::stringstream text;
    text << in.rdbuf();
    CHECK(text.str().find("\"preset\"") == std::string::npos);
    CHECK(text.str().find("\"genus\"") == std::string::npos);
    CHECK(text.str().find("\"top_relief\"") != std::string::npos);  // a key with another value in every genus
  }
}

TEST_CASE("the sun stands within 0.1 degrees of the height in a scene's name") {
  const std::pair<const char*, double> cases[] = {
      {"cumulus_sun60", 60.0}, {"cumulus_sun30", 30.0}, {"cumulus_sun5", 5.0}};
  for (const auto& [name, elevation_deg] : cases) {
    CAPTURE(name);
    CHECK(std::abs(deg_from_rad(sun_of(load_scene(path_of(name))).elevation_rad) - elevation_deg) < 0.1);
  }
}

TEST_CASE("the backlit scene looks towards the sun, whose disc is just outside the picture") {
  const Scene scene = load_scene(path_of("cumulus_backlit"));
  const Horizontal sun = sun_of(scene);
  CHECK(std::abs(deg_from_rad(sun.azimuth_rad) - scene.camera.heading_deg) < 10.0);
  const double top_deg = scene.camera.pitch_deg + 0.5 * scene.camera.fov_deg;
  CHECK(deg_from_rad(sun.elevation_rad) - top_deg > 0.5);
  CHECK(deg_from_rad(sun.elevation_rad) - top_deg < 10.0);
}

TEST_CASE("cameras of the light scenes stand below, above and in the layers as their names say") {
  const auto height = [](const char* name) { return load_scene(path_of(name)).camera.height_m.value(); };
  const auto layer = [](const char* name) { return load_scene(path_of(name)).clouds.layers.at(0); };
  CHECK(height("cumulus_from_below") < layer("cumulus_from_below").base_m);
  CHECK(height("overcast_from_below") < layer("overcast_from_below").base_m);
  const CloudLayer deck = layer("overcast_from_above"), cell = layer("cumulus_inside");
  CHECK(height("overcast_from_above") > deck.base_m + deck.thickness_m);
  CHECK(height("cumulus_inside") > cell.base_m);
  CHECK(height("cumulus_inside") < cell.base_m + cell.thickness_m);
  CHECK(height("cumulus_from_10km") == 10e3);
  CHECK(height("cumulus_from_400km") == 400e3);
  std::set<std::string> channels;
  for (const CloudLayer& l : load_scene(path_of("mixed_layers")).clouds.layers) channels.insert(l.weather_channel);
  CHECK(channels.size() == 3);
}
