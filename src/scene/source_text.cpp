#include "scene/source_text.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "base/error.h"
#include "scene/parameter_text.h"
#include "scene/scene_validate.h"
#include "scene/source_fields.h"

namespace nepho {

namespace {

bool is_word(const std::string& text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalpha(c) || c == '_'; });
}

/// The key of the setting that begins at `at`, up to its '='; empty when no word and '=' are there.
std::string key_at(const std::string& text, size_t at) {
  const size_t end = text.find('=', at);
  const std::string key = end == std::string::npos ? "" : text.substr(at, end - at);
  return is_word(key) ? key : "";
}

template <typename Source>
Source parse(const std::string& text, const std::string& label) {
  Source source;
  const MemberVisit visit = [&source](FieldVisitor& visitor) { describe(visitor, source); };
  std::vector<std::string> keys = member_names(visit);
  std::erase(keys, "path");
  const auto unknown = [&](const std::string& key) {
    const std::string nearest = nearest_name(key, keys);
    return fail(
        ErrorKind::usage, "{}: unknown key '{}' in '{}'; {}", label, key, text,
        nearest.empty() ? fmt::format("known: {}", fmt::join(keys, ", ")) : fmt::format("did you mean '{}'?", nearest));
  };
  const auto known = [&](const std::string& key) { return std::find(keys.begin(), keys.end(), key) != keys.end(); };

  size_t comma = text.find(',');
  for (; comma != std::string::npos; comma = text.find(',', comma + 1)) {
    const std::string key = key_at(text, comma + 1);
    if (known(key)) break;
    std::error_code ec;
    if (!key.empty() && !nearest_name(key, keys).empty() && !std::filesystem::exists(text, ec)) throw unknown(key);
  }
  source.path = text.substr(0, comma);
  while (comma != std::string::npos) {
    const size_t next = text.find(',', comma + 1);
    const std::string setting = text.substr(comma + 1, next == std::string::npos ? next : next - comma - 1);
    const std::string key = key_at(setting, 0);
    if (key.empty())
      throw fail(ErrorKind::usage, "{}: '{}' in '{}' is not key=value; keys: {}", label, setting, text,
                 fmt::join(keys, ", "));
    if (!known(key)) throw unknown(key);
    set_member(visit, key, setting.substr(key.size() + 1), fmt::format("{}: {}", label, key));
    comma = next;
  }
  validate_members(visit, ErrorKind::usage,
                   [&](const std::string& member) { return fmt::format("{}: {}", label, member); });
  if (source.max_zoom >= 0 && source.max_zoom < source.min_zoom)
    throw fail(ErrorKind::usage, "{}: max_zoom: {} is below min_zoom {}", label, source.max_zoom, source.min_zoom);
  return source;
}

}  // namespace

ElevationSource parse_elevation_source(const std::string& text, const std::string& label) {
  return parse<ElevationSource>(text, label);
}
ImagerySource parse_imagery_source(const std::string& text, const std::string& label) {
  return parse<ImagerySource>(text, label);
}

}  // namespace nepho
