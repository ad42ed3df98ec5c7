#include "scene/scene_schema.h"

#include <cctype>
#include <cmath>

#include "base/error.h"
#include "scene/json_text.h"
#include "scene/scene_fields.h"

namespace nepho {

namespace {

Json default_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
Json default_of(const glm::dvec3& value) { return {value.x, value.y, value.z}; }
Json default_of(const Stretch& value) { return json_of_stretch(value); }
template <typename T>
Json default_of(const T& value) {
  return value;
}

Json number_schema(const Field& field, const char* type) {
  Json schema{{"type", type}};
  const Range& range = field.range;
  if (std::isfinite(range.min)) schema[range.min_open ? "exclusiveMinimum" : "minimum"] = range.min;
  if (std::isfinite(range.max)) schema[range.max_open ? "exclusiveMaximum" : "maximum"] = range.max;
  return schema;
}

Json schema_of(const Field& field, double*) { return number_schema(field, "number"); }
Json schema_of(const Field& field, uint32_t*) { return number_schema(field, "integer"); }
Json schema_of(const Field& field, int*) { return number_schema(field, "integer"); }
Json schema_of(const Field& field, std::optional<double>*) {
  Json schema = number_schema(field, "number");
  schema["type"] = {"number", "null"};
  return schema;
}
Json schema_of(const Field& field, glm::dvec3*) {
  return {{"type", "array"}, {"items", number_schema(field, "number")}, {"minItems", 3}, {"maxItems", 3}};
}
Json schema_of(const Field&, bool*) { return {{"type", "boolean"}}; }
Json schema_of(const Field& field, std::string*) {
  Json schema{{"type", "string"}};
  if (!field.choices.empty()) schema["enum"] = field.choices;
  if (field.text == TextKind::file) schema["minLength"] = 1;
  return schema;
}
Json schema_of(const Field&, std::vector<std::string>*) {
  return {{"type", "array"}, {"items", {{"type", "string"}, {"minLength", 1}}}};
}

Json schema_of(const Field&, Stretch*) {
  return {{"anyOf",
           {{{"enum", {"auto", "none"}}},
            {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 2}, {"maxItems", 2}}}}};
}

/// The meaning of a parameter; of a vector, with that of its components.
std::string meaning_of(const Field& field, const Leaf& value) {
  if (!std::holds_alternative<glm::dvec3*>(value)) return field.doc;
  return fmt::format("{}: {}", field.doc, field.components.empty() ? "at 680, 550, 440 nm" : field.components);
}

std::string description_of(const Field& field, const Leaf& value) {
  return field.unit.empty() ? meaning_of(field, value) : fmt::format("{} [{}]", meaning_of(field, value), field.unit);
}

class SchemaWriter : public FieldVisitor {
 public:
  Json properties = Json::object();

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    Json schema = std::visit([&](auto* p) { return schema_of(field, p); }, value);
    schema["description"] = description_of(field, value);
    // A name that must be given has no default.
    if (field.text != TextKind::file) schema["default"] = std::visit([](auto* p) { return default_of(*p); }, value);
    (*at_)[field.name] = std::move(schema);
  }
  void on_group(const Field& field, const std::function<void()>& members) override {
    (*at_)[field.name] = object_schema(field, members);
  }
  void on_preset(const Field& field, const std::function<bool(const std::string&)>&) override {
    Json schema{{"type", "string"}, {"enum", field.choices}, {"description", field.doc}};
    if (!field.standard.empty()) schema["default"] = field.standard;
    (*at_)[field.name] = std::move(schema);
  }
  void on_items(const Field& field, const Items& items) override {
    Json item = object_schema(field, [&] { items.visit_default(*this); });
    if (!items.list) {
      item["type"] = {"object", "null"};
      (*at_)[field.name] = std::move(item);
      return;
    }
    item.erase("description");
    if (!items.shorthand.empty()) {
      item["required"] = {items.shorthand};
      item = {{"anyOf", {{{"type", "string"}, {"minLength", 1}}, std::move(item)}}};
    }
    (*at_)[field.name] = {
        {"type", "array"}, {"description", field.doc}, {"maxItems", items.max}, {"items", std::move(item)}};
  }

 private:
  Json object_schema(const Field& field, const std::function<void()>& members) {
    Json inner = Json::object();
    Json* const outer = at_;
    at_ = &inner;
    members();
    at_ = outer;
    return {{"type", "object"},
            {"description", field.doc},
            {"additionalProperties", false},
            {"properties", std::move(inner)}};
  }
  Json* at_ = &properties;
};

/// One section per group: its own table first, then the sections of the groups in it.
class MarkdownWriter : public FieldVisitor {
 public:
  std::string text() const { return sections_.front().rows + sections_.front().inner; }

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    const Json standard = std::visit([](auto* p) { return default_of(*p); }, value);
    row(field, range_of(field, value), "`" + standard.dump() + "`", meaning_of(field, value));
  }
  void on_group(const Field& field, const std::function<void()>& members) override {
    section(heading(), intro(field), members);
  }
  void on_preset(const Field& field, const std::function<bool(const std::string&)>&) override {
    row(field, fmt::format("{}", fmt::join(field.choices, ", ")),
        field.standard.empty() ? "" : fmt::format("`\"{}\"`", field.standard), field.doc);
  }
  void on_items(const Field& field, const Items& items) override {
    row(field, items.list ? fmt::format("list of 0..{}", items.max) : "see below",
        items.list ? field.standard : "`null`", field.doc);
    const auto members = [&] { items.visit_default(*this); };
    if (items.list)
      at_index(0, [&] { section(heading(), intro(field), members); });
    else
      section(heading(), intro(field), members);
  }

 private:
  struct Section {
    std::string rows, inner;
  };
  static constexpr const char* kHead =
      "\n| key | unit | range | default | meaning | in the literature | in other libraries |\n"
      "|---|---|---|---|---|---|---|\n";

  void row(const Field& field, const std::string& range, const std::string& standard, const std::string& meaning) {
    std::string& rows = sections_.back().rows;
    if (rows.empty()) rows = kHead;
    rows += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", field.name, field.unit, range, standard, meaning,
                        field.term, field.other_names);
  }
  /// The path without the numbers of items: "clouds.layers[].density_profile".
  std::string heading() const {
    std::string text = path();
    for (size_t at; (at = text.find("[0]")) != std::string::npos;) text.erase(at + 1, 1);
    return text;
  }
  void section(const std::string& title, const std::string& introduction, const std::function<void()>& members) {
    sections_.emplace_back();
    members();
    const Section done = std::move(sections_.back());
    sections_.pop_back();
    sections_.back().inner += fmt::format("\n## {}\n\n{}\n{}{}", title, introduction, done.rows, done.inner);
  }
  static std::string intro(const Field& field) {
    std::string text = field.doc + ".";
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    if (!field.term.empty()) text += fmt::format(" In the literature: {}.", field.term);
    if (!field.other_names.empty()) text += fmt::format(" In other libraries: {}.", field.other_names);
    return text;
  }
  static std::string range_of(const Field& field, const Leaf& value) {
    if (!field.choices.empty()) return fmt::format("{}", fmt::join(field.choices, ", "));
    if (std::holds_alternative<bool*>(value)) return "true, false";
    if (std::holds_alternative<std::vector<std::string>*>(value)) return "list of files";
    if (std::holds_alternative<Stretch*>(value)) return "auto, none, [black, white]";
    if (std::holds_alternative<std::string*>(value))
      return field.text == TextKind::utc ? "1900..2100" : field.text == TextKind::plain ? "" : "file";
    return std::holds_alternative<std::optional<double>*>(value) ? field.range.text() + ", null" : field.range.text();
  }
  std::vector<Section> sections_{1};
};

}  // namespace

std::string scene_schema() {
  Scene scene;
  SchemaWriter writer;
  writer.properties["$schema"] = {{"type", "string"}, {"description", "this schema, for editors"}};
  visit_fields(writer, scene);
  const Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                    {"title", "Nephoscope scene"},
                    {"type", "object"},
                    {"additionalProperties", false},
                    {"properties", std::move(writer.properties)}};
  return schema.dump(2) + "\n";
}

std::string parameters_markdown() {
  Scene scene;
  MarkdownWriter writer;
  visit_fields(writer, scene);
  return "# Parameters\n\n"
         "Written by `./nepho schema --parameters` from `src/scene/*_fields.cpp`. Every parameter of a scene file\n"
         "([scene.md](scene.md)). Keys not given have their default. Names in other libraries are those of\n"
         "@takram/three-clouds (its `CloudLayer` and the properties of its `CloudsEffect`).\n" +
         writer.text();
}

}  // namespace nepho
