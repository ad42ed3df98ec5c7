#include "probe_tables.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <iterator>
#include <limits>
#include <ostream>

namespace nepho {

namespace {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Length of what is left of a cell: up to the next comma or line feed.
size_t cell_length(std::string_view rest) {
  return static_cast<size_t>(std::find_if(rest.begin(), rest.end(), [](char c) { return c == ',' || c == '\n'; }) -
                             rest.begin());
}

/// Appends a number as printf's %.17g does, ten times faster.
void append_number(std::string& text, double value) {
  std::array<char, 32> buffer;
  const auto [end, problem] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 17);
  NEPHO_ASSERT(problem == std::errc());
  text.append(buffer.data(), end);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

std::vector<CsvRecord> read_csv(std::istream& in) {
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw fail(ErrorKind::input, "table: cannot be read to its end");
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);

  std::vector<CsvRecord> records;
  for (size_t line = 1; !rest.empty();) {
    CsvRecord record{line, {}};
    if (!records.empty()) record.cells.reserve(records.back().cells.size());
    for (bool more = true; more;) {
      std::string cell;
      std::string_view before = rest.substr(0, std::min(rest.find_first_not_of(" \t"), rest.size()));
      if (rest.substr(before.size()).starts_with('"')) {
        rest.remove_prefix(before.size() + 1);
        for (;; rest.remove_prefix(1)) {
          if (rest.empty()) throw fail(ErrorKind::input, "line {}: a double quote is never closed", record.line);
          if (rest.front() == '\n') ++line;
          if (rest.front() == '"') {
            if (!rest.substr(1).starts_with('"')) break;
            rest.remove_prefix(1);
          }
          cell += rest.front();
        }
        rest.remove_prefix(1);
        std::string_view after = rest.substr(0, cell_length(rest));
        rest.remove_prefix(after.size());
        if (after.ends_with('\r')) after.remove_suffix(1);
        if (!trimmed(after).empty())
          throw fail(ErrorKind::input, "line {}: '{}' follows a closing double quote", line, trimmed(after));
      } else {
        std::string_view plain = rest.substr(0, cell_length(rest));
        rest.remove_prefix(plain.size());
        if (!rest.starts_with(',') && plain.ends_with('\r')) plain.remove_suffix(1);
        cell = trimmed(plain);
      }
      record.cells.push_back(std::move(cell));
      more = rest.starts_with(',');
      if (!rest.empty()) rest.remove_prefix(1);
    }
    ++line;
    const bool blank = record.cells.size() == 1 && record.cells[0].empty();
    if (!blank) records.push_back(std::move(record));
  }
  return records;
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos && trimmed(text).size() == text.size()) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

ProbeTable::ProbeTable(std::string kind, std::span<const ProbeInput> inputs, std::vector<CsvRecord> records)
    : kind_(std::move(kind)) {
  std::vector<std::string> required;
  for (const ProbeInput& input : inputs)
    if (input.group.empty()) required.push_back(input.name);
  if (records.empty())
    throw fail(ErrorKind::input, "probe {}: the table is empty; it needs a header line with {}", kind_,
               joined(required));

  const CsvRecord& header = records.front();
  const auto position_of = [&](const std::string& name) -> std::ptrdiff_t {
    const auto begin = header.cells.begin(), end = header.cells.end();
    const auto first = std::find(begin, end, name);
    if (first == end) return -1;
    if (std::find(first + 1, end, name) != end)
      throw fail(ErrorKind::input, "probe {}: line {}: column '{}' is there twice", kind_, header.line, name);
    return first - begin;
  };

  std::vector<ProbeInput> wanted{{"id", ProbeInput::Type::text, "id"}};
  wanted.insert(wanted.end(), inputs.begin(), inputs.end());
  std::vector<std::pair<ProbeInput, size_t>> found;
  for (const ProbeInput& input : wanted) {
    const std::ptrdiff_t at = position_of(input.name);
    if (at >= 0) {
      found.emplace_back(input, static_cast<size_t>(at));
    } else if (input.group.empty()) {
      const std::string near = nearest_name(input.name, header.cells);
      throw fail(ErrorKind::input, "probe {}: line {}: column '{}' is missing (found: {}){}; needed: {}", kind_,
                 header.line, input.name, joined(header.cells),
                 near.empty() ? std::string() : fmt::format("; is it '{}'?", near), joined(required));
    }
  }

  for (size_t r = 1; r < records.size(); ++r) {
    if (records[r].cells.size() != header.cells.size())
      throw fail(ErrorKind::input, "probe {}: line {}: {} cells where the header has {}{}", kind_, records[r].line,
                 records[r].cells.size(), header.cells.size(),
                 records[r].cells.size() < header.cells.size()
                     ? fmt::format(" (column '{}' is missing)", header.cells[records[r].cells.size()])
                     : std::string());
    lines_.push_back(records[r].line);
  }
  for (const auto& [input, at] : found) {
    Column column{input.name, {}, {}};
    column.texts.reserve(lines_.size());
    for (size_t r = 1; r < records.size(); ++r) column.texts.push_back(std::move(records[r].cells[at]));
    if (input.type != ProbeInput::Type::text) column.numbers.reserve(lines_.size());
    if (input.type != ProbeInput::Type::text)
      for (size_t row = 0; row < rows(); ++row) read_number(input, row, column);
    columns_.push_back(std::move(column));
  }
  check_groups(inputs);
}

void ProbeTable::read_number(const ProbeInput& input, size_t row, Column& column) const {
  const std::string& cell = column.texts[row];
  if (cell.empty() && !input.group.empty()) {
    column.numbers.push_back(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  if (cell.empty()) throw bad_cell(row, input.name, "the cell is empty; a number is needed");
  const char* begin = cell.data() + (cell.front() == '+' && cell.size() > 1 && cell[1] != '-' ? 1 : 0);
  const char* end = cell.data() + cell.size();
  double value = 0.0;
  const auto [stopped, problem] = std::from_chars(begin, end, value);
  if (problem != std::errc() || stopped != end || !std::isfinite(value))
    throw bad_cell(row, input.name, fmt::format("'{}' is not a finite number", cell));
  if (input.type == ProbeInput::Type::latitude_deg && std::abs(value) > 90.0)
    throw bad_cell(row, input.name, fmt::format("{} is outside -90..90", cell));
  column.numbers.push_back(value);
}

void ProbeTable::check_groups(std::span<const ProbeInput> inputs) const {
  // A group is given as a whole: in the header, and in every row.
  for (const ProbeInput& a : inputs)
    for (const ProbeInput& b : inputs) {
      if (a.group.empty() || a.group != b.group || !given(a.name)) continue;
      if (!given(b.name))
        throw fail(ErrorKind::input, "probe {}: column '{}' is missing: it belongs with '{}'", kind_, b.name, a.name);
      for (size_t row = 0; row < rows(); ++row)
        if (find(a.name)->texts[row].empty() < find(b.name)->texts[row].empty())
          throw bad_cell(row, b.name, fmt::format("the cell is empty, but '{}' is not", a.name));
    }
}

const ProbeTable::Column* ProbeTable::find(std::string_view name) const {
  for (const Column& column : columns_)
    if (column.name == name) return &column;
  return nullptr;
}

bool ProbeTable::given(std::string_view column) const { return find(column) != nullptr; }

std::span<const double> ProbeTable::numbers(std::string_view column) const {
  NEPHO_ASSERT(given(column));
  return find(column)->numbers;
}

const std::vector<std::string>& ProbeTable::texts(std::string_view column) const {
  NEPHO_ASSERT(given(column));
  return find(column)->texts;
}

Error ProbeTable::bad_cell(size_t row, std::string_view column, const std::string& why) const {
  return fail(ErrorKind::input, "probe {}: line {}, column '{}': {}", kind_, lines_[row], column, why);
}

void ProbeTable::write(std::ostream& out, const std::vector<ProbeColumn>& results) const {
  constexpr size_t kPiece = 1 << 20;
  std::string text;
  const auto add = [&](bool first, const std::string& cell) {
    if (!first) text += ',';
    text += cell;
  };
  for (const Column& column : columns_) add(&column == &columns_.front(), csv_cell(column.name));
  for (const ProbeColumn& result : results) add(false, csv_cell(result.name));
  text += '\n';
  for (size_t row = 0; row < rows(); ++row) {
    for (const Column& column : columns_) add(&column == &columns_.front(), csv_cell(column.texts[row]));
    for (const ProbeColumn& result : results) {
      NEPHO_ASSERT_OP(std::max(result.values.size(), result.texts.size()), ==, rows());
      text += ',';
      if (!result.texts.empty())
        text += csv_cell(result.texts[row]);
      else if (!std::isnan(result.values[row]))
        append_number(text, result.values[row]);
    }
    text += '\n';
    if (text.size() < kPiece) continue;
    out << text;
    text.clear();
  }
  out << text << std::flush;
  if (!out) throw fail(ErrorKind::failure, "probe {}: the results cannot be written", kind_);
}

}  // namespace nepho
