#include "scene/places.h"

#include <doctest/doctest.h>

#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "scene/scene_json.h"
#include "scene/scene_schema.h"
#include "scene/scene_validate.h"

using namespace nepho;

TEST_CASE("every promised place is there, valid, and has a title and a fixed time") {
  const std::vector<Place> places = named_places();
  for (const char* name :
       {"fuji", "tokyo", "everest", "grand-canyon", "matterhorn", "hawaii", "london", "orbit", "geostationary"}) {
    CAPTURE(name);
    const Place place = find_place(name);
    CHECK_FALSE(place.title.empty());
    Scene scene;
    scene.camera = place.camera;
    scene.time = place.time;
    CHECK_NOTHROW(validate(scene, ErrorKind::input));
    CHECK_FALSE(place.camera.look_at.has_value());  // so that --heading and --pitch alone can turn the view
  }
  CHECK(find_place("orbit").camera.height_m == 400e3);
  CHECK(find_place("geostationary").camera.height_m == 35786e3);
}

TEST_CASE("an unknown place is a usage error that names the nearest one and all of them") {
  try {
    find_place("fugi");
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::usage);
    CHECK(std::string(e.what()).starts_with("--place: 'fugi' is unknown; did you mean 'fuji'? known: fuji, tokyo, "));
  }
}

TEST_CASE("the scenes of data/scenes and the example of docs/scene.md load") {
  size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data_dir() / "scenes")) {
    CAPTURE(entry.path());
    CHECK_NOTHROW(load_scene(entry.path()));
    ++count;
  }
  CHECK(count >= 2);
  const std::string page = read_text_file("docs/scene.md");
  const size_t begin = page.find("```json\n") + 8;
  const Scene scene = scene_from_json(page.substr(begin, page.find("```", begin) - begin), "docs/scene.md");
  CHECK(scene.camera.look_at->height_m == 3700.0);
}

TEST_CASE("docs/scene.schema.json is what ./nepho schema prints") {
  CHECK(read_text_file("docs/scene.schema.json") == scene_schema());
}

TEST_CASE("docs/parameters.md is what ./nepho schema --parameters prints") {
  CHECK(read_text_file("docs/parameters.md") == parameters_markdown());
}
