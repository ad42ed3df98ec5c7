#include "scene/scene_validate.h"

#include <algorithm>
#include <cmath>

#include "scene/scene_fields.h"
#include "scene/scene_time.h"

namespace nepho {

namespace {

class Validator : public FieldVisitor {
 public:
  Validator(ErrorKind kind, const NameParameter& name) : kind_(kind), name_(name) {}

  void check_text(const Field& field, const std::string& value) const {
    const std::vector<std::string>& choices = field.choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end())
      throw wrong(path(), no_choice(value, choices));
    if (field.text == TextKind::file && value.empty()) throw wrong(path(), "is empty; name a file");
    if (field.text == TextKind::utc) {
      try {
        canonical_utc(value);
      } catch (const Error& e) {
        throw wrong(path(), e.what());
      }
    }
  }

  Error wrong(const std::string& path, const std::string& reason) const {
    return Error(kind_, fmt::format("{}: {}", name_ ? name_(path) : path, reason));
  }

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    std::visit([&](auto* p) { check(field, *p); }, value);
  }
  void on_group(const Field&, const std::function<void()>& members) override { members(); }
  void on_items(const Field&, const Items& items) override {
    if (items.size() > items.max)
      throw wrong(path(), fmt::format("{} items found; {} at most", items.size(), items.max));
    for (size_t i = 0; i < items.size(); ++i)
      if (items.list)
        at_index(i, [&] { items.visit(*this, i); });
      else
        items.visit(*this, i);
  }

 private:
  void check_number(const Field& field, const std::string& where, double value) const {
    if (field.range.contains(value)) return;
    throw wrong(where, fmt::format("{} is out of range; allowed: {}", value, field.range.text(field.unit)));
  }
  void check(const Field& field, double value) const { check_number(field, path(), value); }
  void check(const Field& field, uint32_t value) const { check_number(field, path(), value); }
  void check(const Field& field, int value) const { check_number(field, path(), value); }
  void check(const Field& field, const std::optional<double>& value) const {
    if (value) check_number(field, path(), *value);
  }
  void check(const Field& field, const glm::dvec3& value) const {
    for (int i = 0; i < 3; ++i) check_number(field, fmt::format("{}[{}]", path(), i), value[i]);
  }
  void check(const Field&, bool) const {}
  void check(const Field& field, const std::string& value) const { check_text(field, value); }
  void check(const Field& field, const std::vector<std::string>& values) const {
    for (const std::string& value : values) check_text(field, value);
  }
  void check(const Field&, const Stretch& value) const {
    if (value.kind == Stretch::Kind::range && !(value.low < value.high && std::isfinite(value.high - value.low)))
      throw wrong(path(), fmt::format("black {} is not below white {}", value.low, value.high));
  }

  ErrorKind kind_;
  const NameParameter& name_;
};

/// The largest value of a profile over 0..1.
double densest(const DensityProfile& p) {
  const auto at = [&](double eta) {
    return p.exp_term * std::exp(p.exponent * eta) + p.linear_term * eta + p.constant_term;
  };
  double most = std::max(at(0.0), at(1.0));
  // Where the slope is 0, a b exp(b eta) = -c.
  const double ratio = -p.linear_term / (p.exp_term * p.exponent);
  const double eta = ratio > 0.0 && std::isfinite(ratio) ? std::log(ratio) / p.exponent : 0.0;
  if (eta > 0.0 && eta < 1.0) most = std::max(most, at(eta));
  return most;
}

void check_clouds(const CloudParams& clouds, const Validator& validator) {
  for (size_t i = 0; i < clouds.layers.size(); ++i)
    if (clouds.layers[i].density_scale > 0.0 && !(densest(clouds.layers[i].density_profile) > 0.0))
      throw validator.wrong(
          fmt::format("clouds.layers[{}].density_profile", i),
          "nowhere above 0 from base to top; raise constant_term, or leave the layer out with density_scale 0");
  const WeatherParams& weather = clouds.weather;
  if (weather.source == "procedural" && !weather.file.empty())
    throw validator.wrong("clouds.weather.file",
                          fmt::format("'{}' is not looked at by source procedural; give source raster for a map of the "
                                      "globe, tile for a texture that repeats",
                                      weather.file));
  if (weather.source != "procedural" && weather.file.empty())
    throw validator.wrong("clouds.weather.file", fmt::format("is empty; source {} needs a file", weather.source));
}

void check_haze(const HazeParams& haze, const Validator& validator) {
  for (size_t i = 0; i < haze.layers.size(); ++i) {
    const HazeLayer& layer = haze.layers[i];
    if (layer.bottom_m && layer.top_m && *layer.top_m <= *layer.bottom_m)
      throw validator.wrong(fmt::format("haze.layers[{}].top_m", i),
                            fmt::format("{} is not above bottom_m {}", *layer.top_m, *layer.bottom_m));
  }
}

template <typename Source>
void check_zooms(const std::vector<Source>& stack, const char* list, const Validator& validator) {
  for (size_t i = 0; i < stack.size(); ++i)
    if (stack[i].max_zoom >= 0 && stack[i].max_zoom < stack[i].min_zoom)
      throw validator.wrong(fmt::format("{}[{}].max_zoom", list, i),
                            fmt::format("{} is below min_zoom {}", stack[i].max_zoom, stack[i].min_zoom));
}

/// Rules between parameters.
void check_together(const Scene& scene, const Validator& validator) {
  if (scene.camera.height_m && scene.camera.agl_m)
    throw validator.wrong("camera.agl_m", "camera.height_m is given too; keep one of the two");
  if (const auto problem = find_problem(scene.atmosphere))
    throw validator.wrong("atmosphere." + problem->member, problem->reason);
  check_zooms(scene.terrain.elevation, "terrain.elevation", validator);
  check_zooms(scene.imagery.files, "imagery.files", validator);
  check_clouds(scene.clouds, validator);
  check_haze(scene.haze, validator);
  if (const uint32_t u = scene.render.upscale; u != 1 && u != 2 && u != 4 && u != 16)
    throw validator.wrong("render.upscale", fmt::format("{} is not one of 1, 2, 4, 16", u));
  if (scene.render.min_ev100 > scene.render.max_ev100)
    throw validator.wrong("render.min_ev100", fmt::format("{} is larger than max_ev100 {}", scene.render.min_ev100,
                                                          scene.render.max_ev100));
}

class PathLister : public FieldVisitor {
 public:
  std::vector<std::string> paths;

 protected:
  void on_leaf(const Field&, Leaf) override { paths.push_back(path()); }
  void on_group(const Field&, const std::function<void()>& members) override { members(); }
  void on_items(const Field&, const Items& items) override {
    if (items.list)
      at_index(0, [&] { items.visit_default(*this); });
    else
      items.visit_default(*this);
  }
};

}  // namespace

void validate_members(const std::function<void(FieldVisitor&)>& visit, ErrorKind kind, const NameParameter& name) {
  Validator validator(kind, name);
  visit(validator);
}

void validate(const Scene& scene, ErrorKind kind, const NameParameter& name) {
  Scene copy = scene;  // visitors may write, this one does not
  Validator validator(kind, name);
  visit_fields(validator, copy);
  check_together(scene, validator);
}

std::string no_choice(const std::string& value, const std::vector<std::string>& choices) {
  const std::string nearest = nearest_name(value, choices);
  return fmt::format("'{}' is not one of {}{}", value, fmt::join(choices, ", "),
                     nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest));
}

std::vector<std::string> parameter_paths() {
  Scene scene;
  PathLister lister;
  visit_fields(lister, scene);
  return std::move(lister.paths);
}

}  // namespace nepho
