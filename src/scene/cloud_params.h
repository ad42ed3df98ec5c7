#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace nepho {

/// One cloud deck. Names follow docs/clouds.md. Raising `extinction_per_m` darkens bases and sharpens edges.
struct CloudLayer {
  double base_m = 1500.0;          ///< above the ellipsoid, m
  double thickness_m = 1600.0;     ///< m, >= 0; 0 leaves the layer out
  double extinction_per_m = 0.04;  ///< at density 1, 1/m, >= 0
  double shape_amount = 1.0;       ///< 0..1: how much the shape noise carves
  double detail_amount = 0.5;      ///< 0..1: how much the detail noise erodes edges
  bool operator==(const CloudLayer&) const = default;
};

/// The sky's clouds.
struct CloudParams {
  double coverage = 0.4;  ///< vertically projected share of the sky with optical depth > 1, 0..1; 0 is clear
  std::vector<CloudLayer> layers = {CloudLayer{}};  ///< up to four; this slice draws the first
  uint32_t weather_seed = 7;                        ///< another number, another planet's weather
  /// How far large-scale weather departs from `coverage`, 0..0.95: 0 the same everywhere, 0.9 clear deserts beside
  /// overcast storms. The mean over the globe stays `coverage`.
  double weather_contrast = 0.75;
  double wind_east_mps = 0.0;    ///< eastward drift of the whole field at the equator, m/s; the same time, the same sky
  double uniform_density = 0.0;  ///< > 0: the first layer is an even slab of this density; tests of the march
  double phase_g_forward = 0.85;       ///< forward Henyey-Greenstein lobe, (-1, 1)
  double phase_g_backward = -0.2;      ///< backward lobe
  double phase_backward_weight = 0.1;  ///< 0..1
  bool operator==(const CloudParams&) const = default;
};

}  // namespace nepho
