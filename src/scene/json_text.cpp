#include "scene/json_text.h"

#include <algorithm>
#include <set>
#include <vector>

#include "base/error.h"

namespace nepho {

namespace {

/// Line and column (both from 1, columns in bytes) of a byte of a text.
std::string place_in(const std::string& text, size_t offset) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size()));
  const auto line = 1 + std::count(text.begin(), end, '\n');
  const auto line_begin = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  return fmt::format("line {}, column {}", line, std::max<std::ptrdiff_t>(1, end - line_begin));
}

/// The reason in a message of nlohmann::json, without its prefix, on one line of printable characters.
std::string reason_of(const std::string& what) {
  std::string reason = what;
  for (const char* prefix : {"] ", "parse error at line ", ": "}) {
    const size_t at = reason.find(prefix);
    if (at != std::string::npos) reason.erase(0, at + std::string(prefix).size());
  }
  for (char& c : reason)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return reason;
}

}  // namespace

Json parse_json(const std::string& text, const std::string& source) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string repeated;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second && repeated.empty())
      repeated = parsed.get<std::string>();
    return true;
  };
  Json json;
  try {
    json = Json::parse(text, watch);
  } catch (const Json::parse_error& e) {
    throw fail(ErrorKind::input, "{}: {}: not JSON: {}", source, place_in(text, e.byte), reason_of(e.what()));
  } catch (const Json::exception& e) {
    const std::string what = e.what();
    throw fail(ErrorKind::input, "{}: not JSON: {}", source, what.substr(what.find("] ") + 2));
  }
  if (!repeated.empty()) throw fail(ErrorKind::input, "{}: key '{}' occurs twice in one object", source, repeated);
  return json;
}

std::string describe_json(const Json& value) {
  switch (value.type()) {
    case Json::value_t::null:
      return "null";
    case Json::value_t::boolean:
      return value.get<bool>() ? "true" : "false";
    case Json::value_t::string: {
      const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
      return fmt::format("the string {}", text.size() > 40 ? text.substr(0, 36) + "...\"" : text);
    }
    case Json::value_t::array:
      return fmt::format("a list of {}", value.size());
    case Json::value_t::object:
      return "an object";
    default:
      return value.dump();
  }
}

Json json_of_stretch(const Stretch& stretch) {
  if (stretch.kind == Stretch::Kind::range) return {stretch.low, stretch.high};
  return stretch.kind == Stretch::Kind::none ? "none" : "auto";
}

}  // namespace nepho
