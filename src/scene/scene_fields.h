#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene/scene.h"

namespace nepho {

/// Allowed values of a number.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;  ///< `min` itself is not allowed
  bool max_open = false;
  bool contains(double value) const;  ///< false for NaN and infinities
  /// "0..1", "> 0 and < 180 deg".
  std::string text(const std::string& unit = "") const;
};

/// What a string holds. An optional file may be empty.
enum class TextKind { plain, file, optional_file, utc };

/// Everything that is known about one parameter, said once: reading, writing, checks, the JSON Schema and
/// docs/parameters.md follow from it.
struct Field {
  std::string name = {};                  ///< key in JSON, the member's name
  std::string doc = {};                   ///< meaning and visible effect
  std::string unit = {};                  ///< "m", "deg", "1/m"; empty: none
  Range range = {};                       ///< numbers; each component of a vector
  std::string term = {};                  ///< its name, symbol or source in the literature
  std::string other_names = {};           ///< what other libraries call it
  std::string components = {};            ///< of a vector: "east, north, up"; empty: the values at 680, 550, 440 nm
  std::vector<std::string> choices = {};  ///< allowed strings; empty: any
  TextKind text = TextKind::plain;
  std::string standard = {};  ///< of a preset or a list: the default in words; empty: none
};

/// A parameter of a scene at hand.
using Leaf = std::variant<double*, std::optional<double>*, glm::dvec3*, uint32_t*, int*, bool*, std::string*,
                          std::vector<std::string>*, Stretch*>;

class FieldVisitor;

/// A repeated or optional group: `list` is a JSON array of 0..max objects, otherwise an object or null (max = 1).
struct Items {
  bool list = true;
  size_t max = 0;
  std::string shorthand = {};  ///< of a list: the member that a plain string as item stands for; empty: none
  std::function<size_t()> size;
  std::function<void(size_t)> resize;  ///< new items have their defaults
  std::function<void(FieldVisitor&, size_t)> visit;
  std::function<void(FieldVisitor&)> visit_default;  ///< an item of defaults, belonging to no scene
};

/// Walks all parameters of a scene in their order. path() is that of the parameter at hand: "clouds.layers[0].base_m".
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;
  void leaf(const Field& field, Leaf value);
  void group(const Field& field, const std::function<void()>& members);
  void items(const Field& field, const Items& items);
  /// A key that fills the group at hand with one of `field.choices`, before its other members are read. It is read, not
  /// saved: a saved scene has the values themselves. `apply` returns false for an unknown name.
  void preset(const Field& field, const std::function<bool(const std::string& name)>& apply);
  const std::string& path() const { return path_; }

 protected:
  virtual void on_leaf(const Field& field, Leaf value) = 0;
  virtual void on_group(const Field& field, const std::function<void()>& members) = 0;
  virtual void on_items(const Field& field, const Items& items) = 0;
  virtual void on_preset(const Field&, const std::function<bool(const std::string&)>&) {}
  /// Calls `visit` with item `index` of the group at hand as the path.
  void at_index(size_t index, const std::function<void()>& visit);

 private:
  std::string path_;
};

/// The description of every parameter.
void visit_fields(FieldVisitor& visitor, Scene& scene);

}  // namespace nepho
