#pragma once
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include "oracles/oracle_path.h"

namespace nepho {

/// One table of tests/oracles, columns by name.
class OracleTable {
 public:
  explicit OracleTable(const std::string& name) {
    std::ifstream file(test::oracle_path(name));
    REQUIRE_MESSAGE(file.good(), name);
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = split(line);
    for (size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
    while (std::getline(file, line)) rows_.push_back(split(line));
  }
  size_t size() const { return rows_.size(); }
  const std::string& text(size_t row, const std::string& column) const { return rows_[row][columns_.at(column)]; }
  double number(size_t row, const std::string& column) const { return std::stod(text(row, column)); }
  glm::dvec3 xyz(size_t row, const std::string& prefix, const std::string& suffix = "") const {
    return glm::dvec3(number(row, prefix + "_x" + suffix), number(row, prefix + "_y" + suffix),
                      number(row, prefix + "_z" + suffix));
  }
  /// Columns NAME_680, NAME_550, NAME_440.
  glm::dvec3 rgb(size_t row, const std::string& name) const {
    return glm::dvec3(number(row, name + "_680"), number(row, name + "_550"), number(row, name + "_440"));
  }

 private:
  static std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> out;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) out.push_back(field);
    return out;
  }
  std::map<std::string, size_t> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Errors collected over rows and wavelengths.
class ErrorStatistics {
 public:
  explicit ErrorStatistics(std::string what) : what_(std::move(what)) {}
  void add_absolute(const glm::vec3& found, const glm::dvec3& truth) {
    for (int c = 0; c < 3; ++c) errors_.push_back(distance(found[c], truth[c]));
  }
  /// Relative, with the floor of the oracles' README.
  void add_relative(const glm::vec3& found, const glm::dvec3& truth, double floor) {
    for (int c = 0; c < 3; ++c) errors_.push_back(distance(found[c], truth[c]) / std::max(std::abs(truth[c]), floor));
  }
  double quantile(double q) const {
    std::vector<double> sorted = errors_;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty() ? 1e300 : sorted[static_cast<size_t>(q * static_cast<double>(sorted.size() - 1))];
  }
  /// Fails the test beyond the tolerances; the figures show with `test_atmosphere_gpu -s`.
  void check(double median, double p95, double worst = 1e300) const {
    INFO(what_ << ": n " << errors_.size() << ", median " << quantile(0.5) << ", 95 % " << quantile(0.95) << ", worst "
               << quantile(1.0));
    CHECK(quantile(0.5) <= median);
    CHECK(quantile(0.95) <= p95);
    CHECK(quantile(1.0) <= worst);
  }

 private:
  static double distance(double a, double b) { return std::isfinite(a) ? std::abs(a - b) : 1e300; }
  std::string what_;
  std::vector<double> errors_;
};

}  // namespace nepho
