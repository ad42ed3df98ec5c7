#include "scene/parameter_text.h"

#include <charconv>
#include <cmath>

#include "base/error.h"
#include "scene/scene_time.h"

namespace nepho {

namespace {

class NameLister : public FieldVisitor {
 public:
  std::vector<std::string> names;

 protected:
  void on_leaf(const Field& field, Leaf) override { names.push_back(field.name); }
  void on_group(const Field&, const std::function<void()>&) override {}
  void on_items(const Field&, const Items&) override {}
};

/// Finds one parameter by its path.
class Finder : public FieldVisitor {
 public:
  Finder(std::string wanted, std::function<void(const Field&, Leaf)> found)
      : wanted_(std::move(wanted)), found_(std::move(found)) {}
  bool done() const { return done_; }

 protected:
  void on_leaf(const Field& field, Leaf value) override {
    if (path() != wanted_) return;
    found_(field, value);
    done_ = true;
  }
  void on_group(const Field&, const std::function<void()>& members) override { members(); }
  void on_items(const Field&, const Items&) override {}

 private:
  std::string wanted_;
  std::function<void(const Field&, Leaf)> found_;
  bool done_ = false;
};

void find(const MemberVisit& visit, const std::string& path, const std::function<void(const Field&, Leaf)>& found) {
  Finder finder(path, found);
  visit(finder);
  NEPHO_ASSERT(finder.done());  // paths are constants of the program
}

MemberVisit members_of(Scene& scene) {
  return [&scene](FieldVisitor& visitor) { visit_fields(visitor, scene); };
}

class Assigner {
 public:
  Assigner(const Field& field, const std::string& text, const std::string& label)
      : field_(field), text_(text), label_(label) {}
  void operator()(double* value) const { *value = parse_number(text_, label_); }
  void operator()(std::optional<double>* value) const { *value = parse_number(text_, label_); }
  void operator()(uint32_t* value) const { *value = static_cast<uint32_t>(whole_number()); }
  void operator()(int* value) const { *value = static_cast<int>(whole_number()); }
  void operator()(std::string* value) const {
    *value = text_;
    if (field_.text != TextKind::utc) return;
    try {
      *value = canonical_utc(text_);
    } catch (const Error& e) {
      throw fail(ErrorKind::usage, "{}: {}", label_, e.what());
    }
  }
  void operator()(std::vector<std::string>* value) const { *value = {text_}; }
  void operator()(Stretch* value) const {
    *value = {};
    const size_t colon = text_.find(':');
    if (colon != std::string::npos)
      *value = {.kind = Stretch::Kind::range,
                .low = parse_number(text_.substr(0, colon), label_),
                .high = parse_number(text_.substr(colon + 1), label_)};
    else if (text_ == "none")
      value->kind = Stretch::Kind::none;
    else if (text_ != "auto")
      throw fail(ErrorKind::usage, "{}: '{}' is not auto, none or BLACK:WHITE", label_, text_);
  }
  void operator()(bool*) const { NEPHO_ASSERT(!"a switch has no text"); }
  void operator()(glm::dvec3*) const { NEPHO_ASSERT(!"a vector has no option"); }

 private:
  double whole_number() const {
    const double value = parse_number(text_, label_);
    if (!field_.range.contains(value))
      throw fail(ErrorKind::usage, "{}: {} is out of range; allowed: {}", label_, text_,
                 field_.range.text(field_.unit));
    if (std::floor(value) != value) throw fail(ErrorKind::usage, "{}: {} is not a whole number", label_, text_);
    return value;
  }
  const Field& field_;
  const std::string& text_;
  const std::string& label_;
};

}  // namespace

double parse_number(const std::string& text, const std::string& label) {
  double value = 0.0;
  const char* begin = text.data();
  const char* const end = begin + text.size();
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error == std::errc::result_out_of_range)
    throw fail(ErrorKind::usage, "{}: {} is too large or too small for a number", label, text);
  if (error != std::errc{} || stop != end) throw fail(ErrorKind::usage, "{}: '{}' is not a number", label, text);
  return value;
}

Field parameter_field(const std::string& path) {
  Scene scene;
  Field result;
  find(members_of(scene), path, [&](const Field& field, const Leaf&) { result = field; });
  return result;
}

void set_parameter(Scene& scene, const std::string& path, const std::string& text, const std::string& label) {
  set_member(members_of(scene), path, text, label);
}

void set_member(const MemberVisit& visit, const std::string& name, const std::string& text, const std::string& label) {
  find(visit, name, [&](const Field& field, const Leaf& leaf) { std::visit(Assigner(field, text, label), leaf); });
}

std::vector<std::string> member_names(const MemberVisit& visit) {
  NameLister lister;
  visit(lister);
  return std::move(lister.names);
}

}  // namespace nepho
