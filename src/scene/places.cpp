#include "scene/places.h"

#include "base/error.h"
#include "base/files.h"
#include "scene/json_text.h"
#include "scene/scene_json.h"

namespace nepho {

std::vector<Place> named_places() {
  const std::string path = (data_dir() / "places.json").string();
  const Json json = parse_json(read_text_file(path), path);
  if (!json.is_object()) throw fail(ErrorKind::input, "{}: expected an object of places", path);
  std::vector<Place> places;
  for (const auto& [name, entry] : json.items()) {
    const std::string what = fmt::format("{}: {}", path, name);
    if (!entry.is_object() || !entry.contains("title") || !entry["title"].is_string() || !entry.contains("camera"))
      throw fail(ErrorKind::input, "{}: a place is an object with a title, a camera and a time", what);
    for (const auto& [key, value] : entry.items())
      if (key != "title" && key != "camera" && key != "time")
        throw fail(ErrorKind::input, "{}: unknown key '{}'; known here: title, camera, time", what, key);
    Json view = entry;
    view.erase("title");
    const Scene scene = scene_from_json(view.dump(), what);
    places.push_back({name, entry["title"].get<std::string>(), scene.camera, scene.time});
  }
  return places;
}

Place find_place(const std::string& name) {
  std::vector<std::string> names;
  for (Place& place : named_places()) {
    if (place.name == name) return place;
    names.push_back(place.name);
  }
  const std::string nearest = nearest_name(name, names);
  throw fail(ErrorKind::usage, "--place: '{}' is unknown; {}known: {}", name,
             nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest), fmt::join(names, ", "));
}

}  // namespace nepho
