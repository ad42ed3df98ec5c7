#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nepho {

/// Light shafts: the air in the shade of clouds is darker (docs/light.md).
struct ShaftParams {
  /// auto: shadow-length at quality high and ultra, froxel at medium, screen at low; none; shadow-length; froxel;
  /// screen.
  std::string method = "auto";
  double intensity = 1.0;         ///< 0..4: 1 as nature has it; above, half shade counts as more
  uint32_t steps = 32;            ///< points of a ray that look for the sun, 4..256
  uint32_t downscale = 2;         ///< side of the blocks of pixels that share a ray, px, 1..8
  uint32_t froxels_wide = 80;     ///< cells of the frustum grid
  uint32_t froxels_high = 45;     ///< cells
  uint32_t froxel_slices = 64;    ///< cells, exponential in distance
  double froxel_range_m = 150e3;  ///< distance of the last slice, m
  double screen_glow = 0.5;       ///< screen: how much of the sun's glow lies over clouds, 0..10
  bool operator==(const ShaftParams&) const = default;
};

/// Haze or fog: particles of one kind whose density depends on the height alone. Even from `bottom_m` to `base_m`,
/// above that falling by e in every scale height, nothing above `top_m`. Heights are above the ellipsoid.
struct HazeLayer {
  double extinction_per_m = 1.0e-4;     ///< at `base_m`, 1/m, >= 0
  double base_m = 0.0;                  ///< m
  double scale_height_m = 1000.0;       ///< m, > 0
  std::optional<double> bottom_m = {};  ///< m; without: the ground
  std::optional<double> top_m = {};     ///< m; without: none
  double albedo = 0.97;                 ///< single-scattering albedo, 0..1
  double phase_g = 0.7;                 ///< mean cosine of the scattering angle, (-1, 1)
  bool operator==(const HazeLayer&) const = default;
};

struct HazeParams {
  bool enabled = true;
  std::vector<HazeLayer> layers;  ///< up to four
  bool operator==(const HazeParams&) const = default;
};

/// The method that a picture uses: that of its quality for auto.
std::string resolved_shaft_method(const ShaftParams& params, const std::string& quality);
/// The layers that have any effect.
std::vector<HazeLayer> drawn_haze(const HazeParams& params);

}  // namespace nepho
