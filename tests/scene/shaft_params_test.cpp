#include "scene/shaft_params.h"

#include <doctest/doctest.h>

#include "base/error.h"
#include "scene/scene_json.h"
#include "scene/scene_validate.h"

using namespace nepho;

TEST_CASE("shafts auto: shadow-length at high and ultra, froxel at medium, screen at low; a method stays") {
  const ShaftParams params;
  CHECK(resolved_shaft_method(params, "low") == "screen");
  CHECK(resolved_shaft_method(params, "medium") == "froxel");
  CHECK(resolved_shaft_method(params, "high") == "shadow-length");
  CHECK(resolved_shaft_method(params, "ultra") == "shadow-length");
  CHECK(resolved_shaft_method({.method = "none"}, "high") == "none");
}

TEST_CASE("haze: disabled, or without extinction, nothing is drawn") {
  HazeParams haze{.layers = {HazeLayer{}, HazeLayer{.extinction_per_m = 0.0}}};
  CHECK(drawn_haze(haze).size() == 1);
  haze.enabled = false;
  CHECK(drawn_haze(haze).empty());
}

TEST_CASE("haze: a top below the bottom is an error that names the layer") {
  Scene scene;
  scene.haze.layers = {HazeLayer{}, HazeLayer{.bottom_m = 100.0, .top_m = 50.0}};
  try {
    validate(scene, ErrorKind::input);
    FAIL("accepted");
  } catch (const Error& e) {
    CHECK(std::string(e.what()).find("haze.layers[1].top_m: 50 is not above bottom_m 100") != std::string::npos);
  }
}
