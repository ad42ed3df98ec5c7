#pragma once
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "probe.h"
#include "probe_tables.h"

namespace nepho::test {

/// Results of a probe, columns by name. Caches stay in the build folder.
class ProbeResults {
 public:
  ProbeResults(const std::string& kind, const std::string& table, const ProbeOptions& options) {
    ::setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
    std::istringstream in(table);
    std::ostringstream out;
    CHECK(run_probe(kind, in, out, options) == 0);
    std::istringstream again(out.str());
    records_ = read_csv(again);
  }
  const std::vector<std::string>& header() const { return records_.front().cells; }
  size_t size() const { return records_.size() - 1; }
  const std::string& text(size_t row, const std::string& column) const {
    const auto at = std::find(header().begin(), header().end(), column);
    REQUIRE_MESSAGE(at != header().end(), column);
    return records_[row + 1].cells.at(static_cast<size_t>(at - header().begin()));
  }
  double number(size_t row, const std::string& column) const { return std::stod(text(row, column)); }

 private:
  std::vector<CsvRecord> records_;
};

}  // namespace nepho::test
