#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "io/raster.h"
#include "weather/lonlat_grid.h"

namespace nepho {

/// A weather raster (RasterOpener::open_weather) brought onto the cube sphere.
class RasterWeather {
 public:
  /// Reads the raster; says once what it had to fill or leave out. Throws Error(input) when it cannot be read or holds
  /// no data at all.
  explicit RasterWeather(const Raster& raster);

  /// Texels along a face that match the raster's resolution: a power of two, 64..2048.
  uint32_t size() const { return size_; }
  /// RGBA coverage of a face. A raster of one total cover v is split among `channels_used` channels (1..4) so that
  /// independent layers leave the same share of sky clear: 1 - (1 - v)^(1/n).
  std::vector<float> coverage(uint32_t face, uint32_t channels_used) const;
  /// Texels along a face of the properties.
  uint32_t properties_size() const { return properties_size_; }
  /// Type, base offset, density factor, precipitation of a face: neutral but for rain under thick cover.
  std::vector<float> properties(uint32_t face) const;

 private:
  /// The texels of a face, each made of the cover at its place (one number of total cover, or four).
  std::vector<float> face_texels(uint32_t face, uint32_t size,
                                 const std::function<void(const double* cover, float* texel)>& make_texel) const;
  std::optional<LonLatGrid> grid_;
  uint32_t size_ = 64, properties_size_ = 64;
};

/// The share of cover that each of `count` independent layers needs so that together they have the cover `total`.
double split_cover(double total, uint32_t count);

}  // namespace nepho
