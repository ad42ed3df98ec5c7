#include "render/moon_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace nepho {

namespace {

constexpr float kAlbedoOffset = 0.03f, kAlbedoPerGrey = 0.00073f;
constexpr float kGap = 24.0f;           // darker than any mare: the mosaic has no data there
constexpr double kReliefFrom_deg = 72;  // nearer to the poles black is shadow
constexpr float kMareGrey = 50.0f;

/// The whole raster in grey, -1 in gaps.
std::vector<float> grey_of(const Raster& raster) {
  const RasterInfo& info = raster.info();
  std::vector<float> grey(size_t{info.width} * info.height, -1.0f);
  for (uint32_t y0 = 0; y0 < info.height; y0 += Raster::kBlockSize)
    for (uint32_t x0 = 0; x0 < info.width; x0 += Raster::kBlockSize) {
      const Result<RasterBlock> read = raster.read_block(0, x0 / Raster::kBlockSize, y0 / Raster::kBlockSize);
      if (!read) throw fail(ErrorKind::input, "{}", read.reason());
      const RasterBlock& block = *read;
      for (uint32_t y = 0; y < block.height; ++y) {
        const double lat_deg = 90.0 - 180.0 * (y0 + y + 0.5) / info.height;
        const float gap = std::abs(lat_deg) < kReliefFrom_deg ? kGap : -1.0f;
        float* row = &grey[size_t{y0 + y} * info.width + x0];
        for (uint32_t x = 0; x < block.width; ++x) {
          const size_t i = size_t{y} * block.width + x;
          const float* texel = &block.values[i * info.bands];
          const float value = info.bands >= 3 ? (texel[0] + texel[1] + texel[2]) * (1.0f / 3.0f) : texel[0];
          row[x] = !block.valid[i] || value < gap ? -1.0f : std::max(value, kMareGrey * 0.5f);
        }
      }
    }
  return grey;
}

/// Gaps grow shut from their edges, a pixel each round; longitudes wrap.
void fill_gaps(std::vector<float>& grey, uint32_t width, uint32_t height) {
  std::vector<size_t> gaps;
  for (size_t i = 0; i < grey.size(); ++i)
    if (grey[i] < 0.0f) gaps.push_back(i);
  while (!gaps.empty()) {
    std::vector<std::pair<size_t, float>> filled;
    std::vector<size_t> left;
    for (const size_t i : gaps) {
      const auto x = static_cast<uint32_t>(i % width), y = static_cast<uint32_t>(i / width);
      float sum = 0.0f;
      int count = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int64_t row = int64_t{y} + dy;
          if (row < 0 || row >= height) continue;
          const float value = grey[static_cast<size_t>(row) * width + (x + width + static_cast<uint32_t>(dx)) % width];
          if (value < 0.0f) continue;
          sum += value;
          ++count;
        }
      if (count > 0)
        filled.emplace_back(i, sum / static_cast<float>(count));
      else
        left.push_back(i);
    }
    if (filled.empty()) {  // nothing at all is known
      std::fill(grey.begin(), grey.end(), (0.12f - kAlbedoOffset) / kAlbedoPerGrey);
      return;
    }
    for (const auto& [i, value] : filled) grey[i] = value;
    gaps = std::move(left);
  }
}

}  // namespace

float MoonMap::at(double lat_rad, double lon_rad) const {
  const double u = lon_rad / (2.0 * std::numbers::pi) + 0.5, v = 0.5 - lat_rad / std::numbers::pi;
  const double x = std::floor((u - std::floor(u)) * width), y = std::floor(std::clamp(v, 0.0, 1.0) * height);
  return albedo[std::min(static_cast<size_t>(y), size_t{height} - 1) * width +
                std::min(static_cast<size_t>(x), size_t{width} - 1)];
}

MoonMap read_moon_map(const Raster& raster, uint32_t width) {
  const uint32_t from_width = raster.info().width, from_height = raster.info().height;
  std::vector<float> grey = grey_of(raster);
  fill_gaps(grey, from_width, from_height);
  MoonMap map{width, width / 2, {}};
  map.albedo.resize(size_t{map.width} * map.height);
  // Bilinear: the map is nearly as fine as the mosaic (2,700 columns).
  struct Column {
    uint32_t left, right;
    float share;
  };
  std::vector<Column> columns(map.width);
  for (uint32_t i = 0; i < map.width; ++i) {
    const double x = (i + 0.5) / map.width * from_width - 0.5 + from_width;
    const auto whole = static_cast<uint32_t>(x);
    columns[i] = {whole % from_width, (whole + 1) % from_width, static_cast<float>(x - whole)};
  }
  for (uint32_t j = 0; j < map.height; ++j) {
    const double y = std::clamp((j + 0.5) / map.height * from_height - 0.5, 0.0, from_height - 1.0);
    const auto y0 = static_cast<uint32_t>(y), y1 = std::min(y0 + 1, from_height - 1);
    const auto down = static_cast<float>(y - y0);
    const float *upper = &grey[size_t{y0} * from_width], *lower = &grey[size_t{y1} * from_width];
    for (uint32_t i = 0; i < map.width; ++i) {
      const Column& c = columns[i];
      const float top = upper[c.left] + (upper[c.right] - upper[c.left]) * c.share;
      const float bottom = lower[c.left] + (lower[c.right] - lower[c.left]) * c.share;
      map.albedo[size_t{j} * map.width + i] = kAlbedoOffset + kAlbedoPerGrey * (top + (bottom - top) * down);
    }
  }
  return map;
}

}  // namespace nepho
