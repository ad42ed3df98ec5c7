#pragma once
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>

namespace nepho {

/// What `nepho compare` was asked for. All names and numbers are checked.
struct CompareRequest {
  std::filesystem::path a, b;            ///< .exr: the picture and its reference
  std::string mask = "none";             ///< none: all pixels; cloud: where B has cloud
  std::optional<double> exposure_ev100;  ///< without: metered on B
  std::string tone_curve;                ///< empty: that of B's scene, else the default
  std::filesystem::path json;            ///< "-": standard output; empty: a table on standard output instead
  std::filesystem::path heatmap;         ///< .png; empty: none
};

/// Measures how far A is from B (docs/compare.md) and writes what was asked for; `out` is standard output. Throws
/// Error.
void compare_pictures(const CompareRequest& request, std::ostream& out);

}  // namespace nepho
