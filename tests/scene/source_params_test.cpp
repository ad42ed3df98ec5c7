#include "scene/source_params.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "reading_fails.h"
#include "scene/scene_json.h"
#include "scene/source_text.h"

using namespace nepho;
using nepho::test::reading_fails;
namespace fs = std::filesystem;

namespace {

std::string usage_of(const std::string& text) {
  try {
    parse_imagery_source(text, "--imagery");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::usage);
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    return e.what();
  }
  return "(no error)";
}

}  // namespace

TEST_CASE("an entry of a stack is a path, or an object with a path and settings, and both can be mixed") {
  const Scene scene = scene_from_json(
      R"({"terrain": {"elevation": ["a.tif", {"path": "b.tif", "opacity": 0.25, "vertical_datum": "ellipsoid",
                                              "vertical_scale": -1, "encoding": "mapbox", "order": -2}]},
          "imagery": {"files": [{"path": "c.tif", "gamma": 2, "albedo_scale": 0.5, "stretch": [-10, 4000.5],
                                 "min_zoom": 2, "max_zoom": 9}, {"path": "d.tif", "stretch": "none"}, "e.tif"]}})",
      "s.json");
  CHECK(scene.terrain.elevation == std::vector<ElevationSource>{{.path = "a.tif"},
                                                                {.path = "b.tif",
                                                                 .order = -2.0,
                                                                 .opacity = 0.25,
                                                                 .vertical_datum = "ellipsoid",
                                                                 .vertical_scale = -1.0,
                                                                 .encoding = "mapbox"}});
  CHECK(scene.imagery.files ==
        std::vector<ImagerySource>{{.path = "c.tif",
                                    .gamma = 2.0,
                                    .albedo_scale = 0.5,
                                    .stretch = {.kind = Stretch::Kind::range, .low = -10.0, .high = 4000.5},
                                    .min_zoom = 2,
                                    .max_zoom = 9},
                                   {.path = "d.tif", .stretch = {.kind = Stretch::Kind::none}},
                                   {.path = "e.tif"}});
  const std::string saved = scene_to_json(scene);
  CHECK(scene_from_json(saved, "saved.json") == scene);
  CHECK(scene_to_json(scene_from_json(saved, "saved.json")) == saved);
  CHECK(saved.find("\"elevation\": [\n      \"a.tif\",") != std::string::npos);  // nothing but its path: stays short
}

TEST_CASE("wrong entries of a stack are errors with path, what was found and what helps") {
  CHECK(reading_fails(R"({"terrain": {"elevation": [{"path": "a.tif", "opacty": 1}]}})") ==
        "s.json: unknown key 'terrain.elevation[0].opacty'; did you mean 'opacity'?");
  CHECK(reading_fails(R"({"imagery": {"files": ["a.tif", {"path": "a.tif", "vertical_scale": 1}]}})")
            .starts_with("s.json: unknown key 'imagery.files[1].vertical_scale'; "));
  CHECK(reading_fails(R"({"imagery": {"files": [{"opacity": 1}]}})") ==
        "s.json: imagery.files[0].path: is empty; name a file");
  CHECK(reading_fails(R"({"imagery": {"files": [3]}})") ==
        "s.json: imagery.files[0]: expected a string or an object, found 3");
  CHECK(reading_fails(R"({"imagery": {"files": [{"path": "a", "opacity": 1.5}]}})") ==
        "s.json: imagery.files[0].opacity: 1.5 is out of range; allowed: 0..1");
  CHECK(reading_fails(R"({"imagery": {"files": [{"path": "a", "stretch": [2, 2]}]}})") ==
        "s.json: imagery.files[0].stretch: black 2 is not below white 2");
  CHECK(reading_fails(R"({"imagery": {"files": [{"path": "a", "stretch": "full"}]}})") ==
        "s.json: imagery.files[0].stretch: expected \"auto\", \"none\" or a list of 2 numbers, found the string "
        "\"full\"");
  CHECK(reading_fails(R"({"terrain": {"elevation": [{"path": "a", "vertical_datum": "egm69"}]}})") ==
        "s.json: terrain.elevation[0].vertical_datum: 'egm69' is not one of auto, ellipsoid, egm96; did you mean "
        "'egm96'?");
  CHECK(reading_fails(R"({"terrain": {"elevation": [{"path": "a", "min_zoom": 5, "max_zoom": 4}]}})") ==
        "s.json: terrain.elevation[0].max_zoom: 4 is below min_zoom 5");
}

TEST_CASE("an entry on the command line is a path and settings behind commas") {
  CHECK(parse_elevation_source("a.tif", "--terrain") == ElevationSource{.path = "a.tif"});
  CHECK(parse_elevation_source("dem/a.tif,vertical_datum=ellipsoid,vertical_scale=1.5,opacity=0.5,order=3",
                               "--terrain") ==
        ElevationSource{
            .path = "dem/a.tif", .order = 3.0, .opacity = 0.5, .vertical_datum = "ellipsoid", .vertical_scale = 1.5});
  CHECK(parse_imagery_source("https://t.example/{z}/{x}/{y}.png?a=1,2&b=3,max_zoom=12,stretch=-1.5:2e3", "--imagery") ==
        ImagerySource{.path = "https://t.example/{z}/{x}/{y}.png?a=1,2&b=3",
                      .stretch = {.kind = Stretch::Kind::range, .low = -1.5, .high = 2000.0},
                      .max_zoom = 12});
  CHECK(parse_imagery_source("a.tif,stretch=none,gamma=1.2", "--imagery") ==
        ImagerySource{.path = "a.tif", .gamma = 1.2, .stretch = {.kind = Stretch::Kind::none}});
}

TEST_CASE("a comma without a known key after it belongs to the path") {
  for (const char* path :
       {"a,b.tif", "Alps, 2026.tif", "a,x=1.tif", "WMS:http://h/?BBOX=1,2,3,4&LAYERS=a,b", ",", "a,"})
    CHECK(parse_imagery_source(path, "--imagery").path == path);
  CHECK(parse_imagery_source("a,b.tif,opacity=0", "--imagery") == ImagerySource{.path = "a,b.tif", .opacity = 0.0});
}

TEST_CASE("a bad setting on the command line is one line that names option, key and value") {
  CHECK(usage_of("a.tif,opacity=2") == "--imagery: opacity: 2 is out of range; allowed: 0..1");
  CHECK(usage_of("a.tif,opacity=") == "--imagery: opacity: '' is not a number");
  CHECK(usage_of("a.tif,opacity=half") == "--imagery: opacity: 'half' is not a number");
  CHECK(usage_of("a.tif,opacity=1,gama=2") ==
        "--imagery: unknown key 'gama' in 'a.tif,opacity=1,gama=2'; did you mean "
        "'gamma'?");
  CHECK(usage_of("a.tif,opacty=1") == "--imagery: unknown key 'opacty' in 'a.tif,opacty=1'; did you mean 'opacity'?");
  CHECK(usage_of("a.tif,opacity=1,b") ==
        "--imagery: 'b' in 'a.tif,opacity=1,b' is not key=value; keys: order, opacity, gamma, albedo_scale, stretch, "
        "min_zoom, max_zoom");
  CHECK(usage_of("a.tif,stretch=5:1") == "--imagery: stretch: black 5 is not below white 1");
  CHECK(usage_of("a.tif,stretch=most") == "--imagery: stretch: 'most' is not auto, none or BLACK:WHITE");
  CHECK(usage_of("a.tif,max_zoom=23") == "--imagery: max_zoom: 23 is out of range; allowed: -1..22");
  CHECK(usage_of("a.tif,min_zoom=4,max_zoom=3") == "--imagery: max_zoom: 3 is below min_zoom 4");
  CHECK(usage_of(",opacity=1") == "--imagery: path: is empty; name a file");
}

TEST_CASE("a file whose name looks like a misspelt setting is that file") {
  const fs::path file = fs::temp_directory_path() / "nepho_source,opacty=1";
  std::ofstream(file) << "x";
  CHECK(parse_imagery_source(file.string(), "--imagery").path == file.string());
  fs::remove(file);
}

TEST_CASE("names with a driver, a scheme or /vsi are no paths of this machine, others are") {
  for (const char* name :
       {"/vsicurl/https://h/a.tif", "/vsizip/a.zip", "NETCDF:a.nc:v", "WMTS:https://h/x", "GPKG:a.gpkg:t",
        "https://h/{z}/{x}/{y}.png", "<GDAL_WMS></GDAL_WMS>", "HDF5:\"a b.h5\"://d"})
    CHECK_MESSAGE(!is_local_path(name), name);
  for (const char* name : {"a.tif", "/a/b.tif", "2026-06-20T23:30.tif", "./NETCDF:a", "tiles/{z}/{x}/{y}.png", "a b:c"})
    CHECK_MESSAGE(is_local_path(name), name);
}
