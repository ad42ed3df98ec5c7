#pragma once
#include <cstdint>
#include <string>

namespace nepho {

/// Shadow maps of the clouds (docs/light.md). Names follow cascaded shadow maps.
struct CloudShadowParams {
  bool enabled = true;              ///< false: clouds cast no shadows on ground and air
  uint32_t cascades = 3;            ///< 1..4
  uint32_t resolution = 512;        ///< texels along a side of a cascade, 128..1024, in whole tiles of 8
  std::string split = "practical";  ///< of the range among cascades: uniform, logarithmic, practical
  double split_lambda = 0.6;        ///< practical: share of logarithmic, 0..1
  double far_m = 0.0;               ///< distance up to which there are shadows, m; 0: by the camera's height
  uint32_t slices = 16;             ///< frames over which maps that are a little old are made anew, 1..64
  uint32_t rounds = 4;              ///< marches that still maps end up as the mean of, 1..64, one a frame at most
  bool operator==(const CloudShadowParams&) const = default;
};

}  // namespace nepho
