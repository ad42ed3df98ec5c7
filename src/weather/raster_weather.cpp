#include "weather/raster_weather.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
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
  if (count <= 1) return std::clamp(total, 0.0, 1.0);
  return 1.0 - std::pow(1.0 - std::clamp(total, 0.0, 1.0), 1.0 / count);
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

std::vector<float> RasterWeather::face_texels(
    uint32_t face, uint32_t size, const std::function<void(const double* cover, float* texel)>& make_texel) const {
  std::vector<float> out(size_t{size} * size * 4);
  parallel_for(size, [&](size_t row) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < size; ++x) {
      const glm::vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(size));
      const double solid_angle =
          static_cast<double>(shared::cube_solid_angle_density(uv)) / std::pow(static_cast<double>(size), 2.0);
      const LatLonDeg at = lat_lon_from_scaled(cube_texel_direction(size, face, x, y));
      float v[4] = {};
      const double inside = grid_->sample(at.lat_deg, at.lon_deg, texel_deg(solid_angle), v);
      double cover[4] = {};
      for (uint32_t c = 0; c < grid_->channels(); ++c) cover[c] = inside * static_cast<double>(v[c]);
      make_texel(cover, &out[(size_t{y} * size + x) * 4]);
    }
  });
  return out;
}

std::vector<float> RasterWeather::coverage(uint32_t face, uint32_t channels_used) const {
  const bool total = grid_->channels() == 1;
  return face_texels(face, size_, [&](const double* cover, float* texel) {
    if (total)
      std::fill_n(texel, 4, static_cast<float>(split_cover(cover[0], channels_used)));
    else
      for (int c = 0; c < 4; ++c) texel[c] = static_cast<float>(cover[c]);
  });
}

std::vector<float> RasterWeather::properties(uint32_t face) const {
  const bool total = grid_->channels() == 1;
  return face_texels(face, properties_size_, [&](const double* cover, float* texel) {
    // Rain is a guess: under an all but full sky, or under convection where the raster tells it apart.
    const double rain = total ? 0.5 * smooth_step(0.85, 1.0, cover[0]) : smooth_step(0.4, 1.0, cover[3]);
    texel[0] = 0.5f;
    texel[1] = 0.0f;
    texel[2] = 1.0f;
    texel[3] = static_cast<float>(rain);
  });
}

}  // namespace nepho
