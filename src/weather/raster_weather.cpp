#include "weather/raster_weather.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "weather/cube_field.h"

namespace nepho {

namespace {

constexpr uint32_t kSmallestFace = 64, kLargestFace = 2048, kLargestPropertiesFace = 256;
/// A regional raster fades out over this distance.
constexpr double kSoftEdge_deg = 1.0;

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Side of a texel, degrees of great circle: a tent of that half width reaches as far as the next texel's centre.
double texel_deg(double solid_angle) { return deg_from_rad(std::sqrt(solid_angle)); }

}  // namespace

double split_cover(double total, uint32_t count) {
  return 1.0 - std::pow(1.0 - std::clamp(total, 0.0, 1.0), 1.0 / std::max(1u, count));
}

RasterWeather::RasterWeather(const Raster& raster) {
  const RasterInfo& info = raster.info();
  const double pixel_deg = (info.bounds.east_deg - info.bounds.west_deg) / info.width;
  // A face is 90 degrees: the nearest power of two to its pixels.
  const double wanted = std::clamp(90.0 / pixel_deg, double{kSmallestFace}, double{kLargestFace});
  size_ = 1u << static_cast<uint32_t>(std::lround(std::log2(wanted)));
  properties_size_ = std::min(size_, kLargestPropertiesFace);
  grid_.emplace(raster, LonLatGrid::reduction_for(raster, 0.8 * 90.0 / size_));

  const LonLatGrid::Gaps gaps = grid_->separate_outside();
  if (!gaps.any_data) throw fail(ErrorKind::input, "{}: holds no data, every pixel is void", info.path);
  if (gaps.holes > 0.0)
    log_warning("{}: {:.2g} % of its pixels hold no data; they are filled from around them", info.path,
                100.0 * gaps.holes);
  grid_->fill_holes();
  if (!grid_->global())
    log_warning(
        "{}: covers longitude {:.4g} to {:.4g}, latitude {:.4g} to {:.4g}; the sky is clear outside, with a soft edge",
        info.path, info.bounds.west_deg, info.bounds.east_deg, std::max(-90.0, info.bounds.south_deg),
        std::min(90.0, info.bounds.north_deg));
  grid_->soften_edges(kSoftEdge_deg);
}

std::vector<float> RasterWeather::coverage(uint32_t face, uint32_t channels_used) const {
  const std::vector<float> solid_angles = cube_texel_weights(size_);
  std::vector<float> out(size_t{size_} * size_ * 4);
  float v[4] = {};
  for (uint32_t y = 0; y < size_; ++y)
    for (uint32_t x = 0; x < size_; ++x) {
      const LatLonDeg at = lat_lon_from_scaled(cube_texel_direction(size_, face, x, y));
      const size_t i = size_t{y} * size_ + x;
      const double inside = grid_->sample(at.lat_deg, at.lon_deg, texel_deg(static_cast<double>(solid_angles[i])), v);
      for (uint32_t c = 0; c < 4; ++c) {
        const double value = inside * static_cast<double>(v[grid_->channels() == 1 ? 0 : c]);
        out[i * 4 + c] = static_cast<float>(grid_->channels() == 1 ? split_cover(value, channels_used) : value);
      }
    }
  return out;
}

std::vector<float> RasterWeather::properties(uint32_t face) const {
  const uint32_t n = properties_size_;
  const std::vector<float> solid_angles = cube_texel_weights(n);
  std::vector<float> out(size_t{n} * n * 4);
  float v[4] = {};
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const LatLonDeg at = lat_lon_from_scaled(cube_texel_direction(n, face, x, y));
      const size_t i = size_t{y} * n + x;
      const double inside = grid_->sample(at.lat_deg, at.lon_deg, texel_deg(static_cast<double>(solid_angles[i])), v);
      // Rain is a guess: under an all but full sky, or under convection where the raster tells it apart.
      const double rain = grid_->channels() == 1 ? 0.5 * smooth_step(0.85, 1.0, inside * static_cast<double>(v[0]))
                                                 : smooth_step(0.4, 1.0, inside * static_cast<double>(v[3]));
      out[i * 4 + 0] = 0.5f;
      out[i * 4 + 1] = 0.0f;
      out[i * 4 + 2] = 1.0f;
      out[i * 4 + 3] = static_cast<float>(rain);
    }
  return out;
}

}  // namespace nepho
