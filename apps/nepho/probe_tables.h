#pragma once
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "probe.h"

namespace nepho {

/// One line of CSV (RFC 4180: commas, double quotes, LF or CRLF; a quoted cell may span lines).
struct CsvRecord {
  size_t line = 0;  ///< where it begins, counted from 1
  std::vector<std::string> cells;
};

/// Reads all records that are not blank; a UTF-8 byte order mark is skipped. Throws Error(input) for a quote that never
/// closes or text after a closing quote.
std::vector<CsvRecord> read_csv(std::istream& in);

/// The cell as CSV writes it: quoted where it must be.
std::string csv_cell(const std::string& text);

/// A column that a kind of probe reads.
struct ProbeInput {
  enum class Type { number, latitude_deg, text };
  std::string name;
  Type type = Type::number;
  /// Empty: required. Otherwise the columns of one group are given together or not at all, in the table and in each
  /// row.
  std::string group = {};
};

/// A column that a kind of probe writes: numbers or texts. NaN is written as an empty cell: no result, as an optional
/// input was blank or there is none.
struct ProbeColumn {
  std::string name;
  std::vector<double> values;
  std::vector<std::string> texts = {};  ///< instead of values, one a row
};

/// The inputs of a probe, checked: numbers are finite, latitudes -90..90; NaN stands for a blank optional cell.
class ProbeTable {
 public:
  ProbeTable(std::string kind, std::span<const ProbeInput> inputs, std::vector<CsvRecord> records);
  size_t rows() const { return lines_.size(); }
  /// Whether an optional column is in the table.
  bool given(std::string_view column) const;
  std::span<const double> numbers(std::string_view column) const;
  const std::vector<std::string>& texts(std::string_view column) const;
  /// Error(input) that names the row's line and the column.
  Error bad_cell(size_t row, std::string_view column, const std::string& why) const;
  /// Writes id, inputs as they were, and results.
  void write(std::ostream& out, const std::vector<ProbeColumn>& results) const;

 private:
  struct Column {
    std::string name;
    std::vector<std::string> texts;  ///< as given
    std::vector<double> numbers;     ///< empty for texts
  };
  const Column* find(std::string_view name) const;
  void read_number(const ProbeInput& input, size_t row, Column& column) const;
  void check_groups(std::span<const ProbeInput> inputs) const;

  std::string kind_;
  std::vector<size_t> lines_;
  std::vector<Column> columns_;  ///< id where given, then the inputs
};

/// A kind of probe. `evaluate` gets all rows at once, so that kinds that run on the GPU make one dispatch of them.
struct ProbeKind {
  std::string name;
  std::vector<ProbeInput> inputs;
  std::function<std::vector<ProbeColumn>(const ProbeTable&, const ProbeOptions&)> evaluate;
};

/// The kinds of one subject; probe.cpp lists the subjects.
std::vector<ProbeKind> geo_probe_kinds();
std::vector<ProbeKind> astro_probe_kinds();
std::vector<ProbeKind> atmosphere_probe_kinds();
std::vector<ProbeKind> cloud_probe_kinds();
std::vector<ProbeKind> slab_probe_kinds();
std::vector<ProbeKind> terrain_probe_kinds();

}  // namespace nepho
