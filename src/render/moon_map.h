#pragma once
#include <cstdint>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// Normal albedo of the moon on a map from 180 W to 180 E and 90 N to 90 S.
struct MoonMap {
  uint32_t width = 1, height = 1;
  std::vector<float> albedo{0.12f};  ///< row 0 northernmost; without a texture even
  float at(double lat_rad, double lon_rad) const;
};

/// Reads the Clementine mosaic (or any imagery that spans the moon like it) into `width` columns. Its grey values
/// follow reflectance; they are scaled so that maria (50) have an albedo of 0.066 and highlands (138) of 0.13. Gaps,
/// black in the mosaic, take the mean of their surroundings. Throws Error(input) when a block cannot be read.
MoonMap read_moon_map(const Raster& raster, uint32_t width);

}  // namespace nepho
