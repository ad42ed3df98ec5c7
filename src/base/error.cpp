#include "base/error.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>

namespace nepho {

namespace {
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}
}  // namespace

std::string nearest_name(const std::string& wanted, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = std::max<size_t>(2, wanted.size() / 2);
  for (const std::string& name : known) {
    const size_t distance = edit_distance(wanted, name);
    if (distance < best_distance || (best.empty() && distance == best_distance)) {
      best = name;
      best_distance = distance;
    }
  }
  return best;
}

void assert_failed(const char* expression, const char* file, int line, const std::string& values) {
  std::fprintf(stderr, "nepho: internal error: %s is false%s%s (%s:%d)\n", expression, values.empty() ? "" : ": ",
               values.c_str(), file, line);
  std::abort();
}

}  // namespace nepho
