#include "scene/scene_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>

#include "base/error.h"
#include "base/files.h"
#include "scene/json_text.h"
#include "scene/scene_fields.h"
#include "scene/scene_time.h"
#include "scene/scene_validate.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

/// Fills a scene from a JSON object. Types and integers are checked here, ranges by validate().
class Reader : public FieldVisitor {
 public:
  Reader(const Json& root, std::string source) : source_(std::move(source)) { open(root); }
  /// To be called after the visit.
  void finish() { close(); }

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    if (const Json* json = find(field)) std::visit([&](auto* p) { read(field, *json, *p); }, value);
  }
  void on_group(const Field& field, const std::function<void()>& members) override {
    const Json* json = find(field);
    if (!json) return;
    open(*json);
    members();
    close();
  }
  void on_preset(const Field& field, const std::function<bool(const std::string&)>& apply) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_string()) throw wrong_type("a string", *json);
    if (!apply(json->get<std::string>()))
      throw fail(ErrorKind::input, "{}: {}: {}", source_, path(), no_choice(json->get<std::string>(), field.choices));
  }
  void on_items(const Field& field, const Items& items) override {
    const Json* json = find(field);
    if (!json) return;
    if (!items.list) {
      items.resize(json->is_null() ? 0 : 1);
      if (json->is_null()) return;
      open(*json);
      items.visit(*this, 0);
      close();
      return;
    }
    if (!json->is_array()) throw wrong_type("a list", *json);
    if (json->size() > items.max)
      throw fail(ErrorKind::input, "{}: {}: {} items found; {} at most", source_, path(), json->size(), items.max);
    items.resize(json->size());
    for (size_t i = 0; i < json->size(); ++i)
      at_index(i, [&] {
        const Json& item = (*json)[i];
        if (!items.shorthand.empty() && !item.is_object() && !item.is_string())
          throw wrong_type("a string or an object", item);
        const bool is_short = !items.shorthand.empty() && item.is_string();
        const Json whole = is_short ? Json{{items.shorthand, item}} : Json();
        open(is_short ? whole : item);
        items.visit(*this, i);
        close();
      });
  }

 private:
  struct OpenObject {
    const Json* json;
    std::vector<std::string> known;
  };

  void open(const Json& json) {
    if (!json.is_object()) throw wrong_type("an object", json);
    open_.push_back({&json, {}});
  }
  void close() {
    const OpenObject& object = open_.back();
    for (const auto& [key, value] : object.json->items()) {
      if (std::find(object.known.begin(), object.known.end(), key) != object.known.end()) continue;
      if (open_.size() == 1 && key == "$schema" && value.is_string()) continue;  // editors look there
      const std::string nearest = nearest_name(key, object.known);
      throw fail(ErrorKind::input, "{}: unknown key '{}{}{}'; {}", source_, path(), path().empty() ? "" : ".", key,
                 nearest.empty() ? fmt::format("known here: {}", fmt::join(object.known, ", "))
                                 : fmt::format("did you mean '{}'?", nearest));
    }
    open_.pop_back();
  }
  const Json* find(const Field& field) {
    open_.back().known.push_back(field.name);
    const auto found = open_.back().json->find(field.name);
    return found == open_.back().json->end() ? nullptr : &*found;
  }
  Error wrong_type(const char* expected, const Json& found) const {
    return fail(ErrorKind::input, "{}: {}{}expected {}, found {}", source_, path(), path().empty() ? "" : ": ",
                expected, describe_json(found));
  }

  void read(const Field&, const Json& json, double& value) const {
    if (!json.is_number()) throw wrong_type("a number", json);
    value = json.get<double>();
  }
  void read(const Field& field, const Json& json, std::optional<double>& value) const {
    if (json.is_null()) {
      value.reset();
    } else {
      if (!json.is_number()) throw wrong_type("a number or null", json);
      read(field, json, value.emplace());
    }
  }
  void read(const Field& field, const Json& json, glm::dvec3& value) const {
    if (!json.is_array() || json.size() != 3) throw wrong_type("a list of 3 numbers", json);
    for (int i = 0; i < 3; ++i) read(field, json[static_cast<size_t>(i)], value[i]);
  }
  /// A whole number within the field's range, which fits the member's type.
  double whole_number(const Field& field, const Json& json) const {
    if (!json.is_number() || std::floor(json.get<double>()) != json.get<double>())
      throw wrong_type("a whole number", json);
    if (!field.range.contains(json.get<double>()))
      throw fail(ErrorKind::input, "{}: {}: {} is out of range; allowed: {}", source_, path(), json.dump(),
                 field.range.text(field.unit));
    return json.get<double>();
  }
  void read(const Field& field, const Json& json, uint32_t& value) const {
    value = static_cast<uint32_t>(whole_number(field, json));
  }
  void read(const Field& field, const Json& json, int& value) const {
    value = static_cast<int>(whole_number(field, json));
  }
  void read(const Field&, const Json& json, bool& value) const {
    if (!json.is_boolean()) throw wrong_type("true or false", json);
    value = json.get<bool>();
  }
  void read(const Field& field, const Json& json, std::string& value) const {
    if (!json.is_string()) throw wrong_type("a string", json);
    value = json.get<std::string>();
    if (field.text != TextKind::utc) return;
    try {
      value = canonical_utc(value);
    } catch (const Error& e) {
      throw fail(ErrorKind::input, "{}: {}: {}", source_, path(), e.what());
    }
  }
  void read(const Field&, const Json& json, Stretch& value) const {
    value = {};
    if (json.is_array() && json.size() == 2 && json[0].is_number() && json[1].is_number())
      value = {.kind = Stretch::Kind::range, .low = json[0].get<double>(), .high = json[1].get<double>()};
    else if (json == "none")
      value.kind = Stretch::Kind::none;
    else if (json != "auto")
      throw wrong_type("\"auto\", \"none\" or a list of 2 numbers", json);
  }
  void read(const Field& field, const Json& json, std::vector<std::string>& values) const {
    if (!json.is_array()) throw wrong_type("a list of strings", json);
    values.clear();
    for (const Json& item : json) read(field, item, values.emplace_back());
  }

  std::string source_;
  std::vector<OpenObject> open_;
};

class Writer : public FieldVisitor {
 public:
  Json root = Json::object();

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    std::visit([&](auto* p) { (*at_)[field.name] = json_of(*p); }, value);
  }
  void on_group(const Field& field, const std::function<void()>& members) override {
    write_object((*at_)[field.name], members);
  }
  void on_items(const Field& field, const Items& items) override {
    Json& json = (*at_)[field.name];
    if (!items.list) {
      if (items.size() > 0) write_object(json, [&] { items.visit(*this, 0); });
      return;  // null otherwise
    }
    json = Json::array();
    Json defaults;
    if (!items.shorthand.empty()) write_object(defaults, [&] { items.visit_default(*this); });
    for (size_t i = 0; i < items.size(); ++i) {
      Json item;
      write_object(item, [&] { items.visit(*this, i); });
      if (!items.shorthand.empty()) {
        defaults[items.shorthand] = item[items.shorthand];
        if (item == defaults) item = Json(item[items.shorthand]);
      }
      json.push_back(std::move(item));
    }
  }

 private:
  void write_object(Json& json, const std::function<void()>& members) {
    json = Json::object();
    Json* const outer = at_;
    at_ = &json;
    members();
    at_ = outer;
  }
  template <typename T>
  static Json json_of(const T& value) {
    return value;
  }
  static Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
  static Json json_of(const glm::dvec3& value) { return {value.x, value.y, value.z}; }
  static Json json_of(const Stretch& value) { return json_of_stretch(value); }

  Json* at_ = &root;
};

/// Calls a function with the name of every file of a scene that is a path of this machine.
class FileVisitor : public FieldVisitor {
 public:
  explicit FileVisitor(const std::function<void(std::string&)>& use) : use_(use) {}

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    if (field.text != TextKind::file && field.text != TextKind::optional_file) return;
    if (std::string* const* file = std::get_if<std::string*>(&value)) use(**file);
    if (std::vector<std::string>* const* files = std::get_if<std::vector<std::string>*>(&value))
      for (std::string& file : **files) use(file);
  }
  void on_group(const Field&, const std::function<void()>& members) override { members(); }
  void on_items(const Field&, const Items& items) override {
    for (size_t i = 0; i < items.size(); ++i) items.visit(*this, i);
  }

 private:
  void use(std::string& file) {
    if (!file.empty() && is_local_path(file)) use_(file);
  }
  const std::function<void(std::string&)>& use_;
};

void for_each_file(Scene& scene, const std::function<void(std::string&)>& change) {
  FileVisitor visitor(change);
  visit_fields(visitor, scene);
}

}  // namespace

std::vector<std::string> local_files(const Scene& scene) {
  Scene copy = scene;
  std::vector<std::string> files;
  for_each_file(copy, [&](std::string& file) { files.push_back(file); });
  return files;
}

bool is_local_path(const std::string& raster) {
  if (raster.starts_with("/vsi") || raster.starts_with('<')) return false;  // '<': a description in XML
  // A driver's prefix (NETCDF:, WMTS:) or a scheme (https:); "2026-06-20T23:30.tif" has none.
  const size_t end = std::find_if_not(raster.begin(), raster.end(),
                                      [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '+'; }) -
                     raster.begin();
  const bool has_prefix =
      end > 1 && end < raster.size() && raster[end] == ':' && std::isalpha(static_cast<unsigned char>(raster[0]));
  return !has_prefix;
}

void merge_scene_json(Scene& scene, const std::string& text, const std::string& what) {
  const Json json = parse_json(text, what);
  Reader reader(json, what);
  visit_fields(reader, scene);
  reader.finish();
  validate(scene, ErrorKind::input, [&](const std::string& path) { return fmt::format("{}: {}", what, path); });
}

Scene scene_from_json(const std::string& text, const std::string& source) {
  Scene scene;
  merge_scene_json(scene, text, source);
  return scene;
}

Scene load_scene(const fs::path& path) {
  Scene scene = scene_from_json(read_text_file(path), path.string());
  for_each_file(scene, [&](std::string& file) {
    if (fs::path(file).is_relative()) file = (path.parent_path() / file).lexically_normal().string();
  });
  return scene;
}

std::string scene_to_json(const Scene& scene) {
  Scene copy = scene;  // visitors may write, this one does not
  Writer writer;
  visit_fields(writer, copy);
  return writer.root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void save_scene(const fs::path& path, const Scene& scene) {
  Scene placed = scene;
  const fs::path folder = fs::absolute(path).lexically_normal().parent_path();
  for_each_file(placed, [&](std::string& file) {
    const fs::path whole = fs::absolute(file).lexically_normal();
    const fs::path inside = whole.lexically_relative(folder);
    file = (inside.empty() || *inside.begin() == ".." ? whole : inside).string();
  });
  write_whole_file(path, [&](const fs::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file << scene_to_json(placed);
    if (!file.flush()) throw fail(ErrorKind::failure, "{}: cannot be written", path.string());
  });
}

}  // namespace nepho
