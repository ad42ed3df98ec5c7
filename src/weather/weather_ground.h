#pragma once
#include <memory>
#include <vector>

#include "geo/geoid.h"
#include "io/raster.h"

namespace nepho {

/// What base heights stand on, on the cube sphere: per texel the geoid's undulation and the smoothed ground, both in m
/// above the ellipsoid.
struct WeatherGround {
  static constexpr uint32_t kSize = 256;  ///< texels along a face: 40 km
  std::vector<float> texels;              ///< 6 * kSize * kSize pairs
  double lowest_geoid_m = 0.0, highest_geoid_m = 0.0;
  double lowest_ground_m = 0.0, highest_ground_m = 0.0;
};

/// Later rasters lie over earlier ones; where none has data the ground is the ellipsoid, as it is drawn. Land below the
/// sea's level counts as sea, whose height is the geoid's. Kept in cache_dir(), keyed by the rasters' paths and sizes.
/// Throws Error(input) when a raster cannot be read.
WeatherGround make_weather_ground(const std::vector<std::shared_ptr<Raster>>& elevation, const Geoid* geoid);

}  // namespace nepho
