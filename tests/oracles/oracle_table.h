#pragma once
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "oracles/oracle_path.h"

namespace nepho::test {

/// One row of an oracle table: columns by name. A missing column throws, so that a renamed one cannot pass unseen.
class OracleRow {
 public:
  explicit OracleRow(std::map<std::string, std::string> cells) : cells_(std::move(cells)) {}
  const std::string& text(const std::string& column) const { return cells_.at(column); }
  double number(const std::string& column) const { return std::strtod(cells_.at(column).c_str(), nullptr); }
  int id() const { return std::atoi(cells_.at("id").c_str()); }

 private:
  std::map<std::string, std::string> cells_;
};

/// Reads tests/oracles/<name>.csv (plain commas, a header line; the numbers' sources are in docs/units_and_frames.md).
inline std::vector<OracleRow> oracle_table(const std::string& name) {
  const std::string path = oracle_path(name + ".csv");
  std::ifstream file(path);
  if (!file) throw std::runtime_error("missing oracle table " + path);
  std::string line, cell;
  const auto split = [&] {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    while (std::getline(stream, cell, ',')) cells.push_back(cell);
    return cells;
  };
  std::getline(file, line);
  const std::vector<std::string> header = split();
  std::vector<OracleRow> rows;
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = split();
    if (cells.size() != header.size()) throw std::runtime_error("bad row in " + path + ": " + line);
    std::map<std::string, std::string> row;
    for (size_t i = 0; i < header.size(); ++i) row[header[i]] = cells[i];
    rows.emplace_back(std::move(row));
  }
  return rows;
}

}  // namespace nepho::test
