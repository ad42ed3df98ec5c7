#pragma once
#include <array>
#include <string>
#include <vector>

namespace nepho {

/// One cloud deck. Names follow docs/clouds.md. Raising `extinction_per_m` darkens bases and sharpens edges.
struct CloudLayer {
  double base_m = 1500.0;           ///< above the ellipsoid, m
  double thickness_m = 1600.0;      ///< m, >= 0; 0 leaves the layer out
  double extinction_per_m = 0.04;   ///< at density 1, 1/m, >= 0
  double shape_amount = 1.0;        ///< 0..1: how much the shape noise carves
  double detail_amount = 0.5;       ///< 0..1: how much the detail noise erodes edges
  bool operator==(const CloudLayer&) const = default;
};

/// The sky's clouds.
struct CloudParams {
  double coverage = 0.4;  ///< vertically projected share of the sky with optical depth > 1, 0..1; 0 is clear
  std::vector<CloudLayer> layers = {CloudLayer{}};  ///< up to four; this slice draws the first
  double phase_g_forward = 0.85;   ///< forward Henyey-Greenstein lobe, (-1, 1)
  double phase_g_backward = -0.2;  ///< backward lobe
  double phase_backward_weight = 0.1;  ///< 0..1
  bool operator==(const CloudParams&) const = default;
};

}  // namespace nepho
