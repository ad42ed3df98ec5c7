#include "geo/geoid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/files.h"
#include "base/log.h"
#include "geo/geodetic.h"

namespace nepho {

namespace {

constexpr size_t kHeaderBytes = 40;  // south, west, lat step, lon step: double; rows, columns: int32; all big-endian

// Spelt out so that compilers make it one load and one byte swap: a million values are read at start-up.
uint32_t big_endian_u32(const char* bytes) {
  const auto byte = [bytes](int i) { return static_cast<uint32_t>(static_cast<unsigned char>(bytes[i])); };
  return byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
}

double big_endian_double(const char* bytes) {
  return std::bit_cast<double>(uint64_t{big_endian_u32(bytes)} << 32 | big_endian_u32(bytes + 4));
}

std::array<double, 4> catmull_rom(double t) {
  return {0.5 * t * (-1.0 + t * (2.0 - t)), 0.5 * (2.0 + t * t * (-5.0 + 3.0 * t)),
          0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
}

}  // namespace

const Geoid& Geoid::egm96() {
  static const Geoid geoid = [] {
    Geoid g(find_egm96());
    if (!g.available())
      log_warning(
          "{}; heights above sea level are taken as heights above the ellipsoid (up to 107 m off); "
          "install the package proj-data",
          g.problem());
    return g;
  }();
  return geoid;
}

std::filesystem::path Geoid::find_egm96() {
  std::vector<std::string> folders;
  for (const char* variable : {"PROJ_DATA", "PROJ_LIB"}) {
    const char* value = std::getenv(variable);
    if (!value) continue;
    const std::string list = value;
    for (size_t begin = 0; begin <= list.size();) {
      const size_t end = std::min(list.find(':', begin), list.size());
      if (end > begin) folders.push_back(list.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  folders.push_back((data_dir() / "earth").string());
  folders.insert(folders.end(), {"/usr/share/proj", "/usr/local/share/proj"});
  for (const std::string& folder : folders) {
    const std::filesystem::path file = std::filesystem::path(folder) / "egm96_15.gtx";
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) return file;
  }
  return {};
}

Geoid::Geoid(const std::filesystem::path& gtx_file) {
  if (gtx_file.empty()) {
    problem_ = "egm96_15.gtx not found in $PROJ_DATA, $PROJ_LIB or /usr/share/proj";
  } else if (const std::string why = read(gtx_file); !why.empty()) {
    problem_ = fmt::format("{}: {}", gtx_file.string(), why);
  }
}

std::string Geoid::read(const std::filesystem::path& gtx_file) {
  std::ifstream file(gtx_file, std::ios::binary);
  if (!file) return "cannot be read";
  std::array<char, kHeaderBytes> header{};
  if (!file.read(header.data(), header.size())) return "not a GTX grid: shorter than its header";
  south_deg_ = big_endian_double(header.data());
  west_deg_ = big_endian_double(header.data() + 8);
  step_lat_deg_ = big_endian_double(header.data() + 16);
  step_lon_deg_ = big_endian_double(header.data() + 24);
  rows_ = static_cast<int32_t>(big_endian_u32(header.data() + 32));
  columns_ = static_cast<int32_t>(big_endian_u32(header.data() + 36));
  const bool sane = rows_ >= 2 && columns_ >= 4 && rows_ <= 20000 && columns_ <= 40000 && columns_ % 2 == 0;
  const bool global = sane && std::abs(south_deg_ + 90.0) < 1e-9 && std::abs(west_deg_) <= 360.0 &&
                      std::abs(static_cast<double>(rows_ - 1) * step_lat_deg_ - 180.0) < 1e-6 &&
                      std::abs(static_cast<double>(columns_) * step_lon_deg_ - 360.0) < 1e-6;
  if (!global) return "not a GTX grid of the whole globe";
  const size_t count = static_cast<size_t>(rows_ * columns_);
  std::error_code size_error;
  // Compared before anything is allocated: a broken header may announce gigabytes.
  if (std::filesystem::file_size(gtx_file, size_error) < kHeaderBytes + 4 * count || size_error)
    return fmt::format("ends early: {} x {} values were announced", columns_, rows_);
  std::vector<float> values(count);
  if (!file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(4 * count)))
    return "cannot be read to its end";
  bool all_good = true;
  for (float& v : values) {
    v = std::bit_cast<float>(big_endian_u32(reinterpret_cast<const char*>(&v)));
    all_good &= std::abs(v) < 1000.0f;  // false for NaN
  }
  if (!all_good) return "holds values that are no undulations";
  values_m_ = std::move(values);
  return {};
}

Geoid::Cell Geoid::cell_at(double lat_rad, double lon_rad) const {
  const double y =
      std::clamp((deg_from_rad(lat_rad) - south_deg_) / step_lat_deg_, 0.0, static_cast<double>(rows_ - 1));
  const double east = deg_from_rad(lon_rad) - west_deg_;
  const double x = (east - 360.0 * std::floor(east / 360.0)) / step_lon_deg_;
  Cell cell;
  cell.row = std::min(static_cast<int64_t>(y), rows_ - 2);
  cell.column = static_cast<int64_t>(x);
  cell.fy = y - static_cast<double>(cell.row);
  cell.fx = x - static_cast<double>(cell.column);
  return cell;
}

double Geoid::node(int64_t row, int64_t column) const {
  // Over a pole the grid goes on along the opposite meridian.
  if (row < 0 || row >= rows_) {
    row = row < 0 ? -row : 2 * (rows_ - 1) - row;
    column += columns_ / 2;
  }
  column = (column % columns_ + columns_) % columns_;
  return static_cast<double>(values_m_[static_cast<size_t>(row * columns_ + column)]);
}

double Geoid::undulation_m(double lat_rad, double lon_rad) const {
  if (!available()) return 0.0;
  if (!std::isfinite(lat_rad + lon_rad)) return std::numeric_limits<double>::quiet_NaN();
  const Cell c = cell_at(lat_rad, lon_rad);
  const double south = (1.0 - c.fx) * node(c.row, c.column) + c.fx * node(c.row, c.column + 1);
  const double north = (1.0 - c.fx) * node(c.row + 1, c.column) + c.fx * node(c.row + 1, c.column + 1);
  return (1.0 - c.fy) * south + c.fy * north;
}

double Geoid::undulation_bicubic_m(double lat_rad, double lon_rad) const {
  if (!available()) return 0.0;
  if (!std::isfinite(lat_rad + lon_rad)) return std::numeric_limits<double>::quiet_NaN();
  const Cell c = cell_at(lat_rad, lon_rad);
  const std::array<double, 4> wx = catmull_rom(c.fx), wy = catmull_rom(c.fy);
  double sum = 0.0;
  for (int64_t j = 0; j < 4; ++j)
    for (int64_t i = 0; i < 4; ++i)
      sum += wy[static_cast<size_t>(j)] * wx[static_cast<size_t>(i)] * node(c.row + j - 1, c.column + i - 1);
  return sum;
}

}  // namespace nepho
