#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nepho {

/// Height of mean sea level above the ellipsoid, from a global GTX grid (proj-data's egm96_15.gtx, 15 arc minutes).
/// height above the ellipsoid = height above mean sea level + undulation. Immutable, so thread-safe.
class Geoid {
 public:
  /// EGM96, read once. Where the file is missing or broken: one warning, and undulations of 0.
  static const Geoid& egm96();

  /// Reads a grid; empty path or an unreadable file: not available, `problem()` says why.
  explicit Geoid(const std::filesystem::path& gtx_file);

  /// The file as PROJ finds it: the folders of $PROJ_DATA and $PROJ_LIB, then that of a packaged program
  /// (data_dir()/earth), /usr/share/proj and /usr/local/share/proj. Empty when it is nowhere.
  static std::filesystem::path find_egm96();

  bool available() const { return !values_m_.empty(); }
  const std::string& problem() const { return problem_; }

  /// Undulation in m, -107..86 for EGM96: bilinear, as PROJ does. 0 when not available. Any longitude; NaN in, NaN out.
  double undulation_m(double lat_rad, double lon_rad) const;
  /// Catmull-Rom over 4x4 nodes, continued over the poles: smoother; up to 0.9 m from the bilinear one in trenches.
  double undulation_bicubic_m(double lat_rad, double lon_rad) const;

 private:
  struct Cell {
    int64_t row = 0, column = 0;  ///< south-west node
    double fy = 0.0, fx = 0.0;    ///< 0..1 within the cell
  };
  std::string read(const std::filesystem::path& gtx_file);  ///< why not, or empty
  Cell cell_at(double lat_rad, double lon_rad) const;
  double node(int64_t row, int64_t column) const;

  std::string problem_;
  int64_t rows_ = 0, columns_ = 0;
  double south_deg_ = 0.0, west_deg_ = 0.0, step_lat_deg_ = 1.0, step_lon_deg_ = 1.0;
  std::vector<float> values_m_;  ///< rows south to north, columns eastwards; columns_ steps make 360 degrees
};

}  // namespace nepho
