#include "scene/scene_time.h"

#include "astro/utc_time.h"

namespace nepho {

std::string canonical_utc(const std::string& text) {
  std::string exact = format_utc(parse_utc(text), 9);
  // Trailing zeros of the fraction, and the point of an empty one, stand just before the Z.
  exact.pop_back();
  exact.erase(exact.find_last_not_of('0') + 1);
  if (exact.back() == '.') exact.pop_back();
  return exact + 'Z';
}

}  // namespace nepho
