#include "compare/plane.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace nepho {

Plane filtered(const Plane& plane, std::span<const double> along_x, std::span<const double> along_y) {
  NEPHO_ASSERT(along_x.size() % 2 == 1 && along_y.size() % 2 == 1);
  const uint32_t width = plane.width, height = plane.height;
  Plane rows(width, height), out(width, height);
  const size_t rx = along_x.size() / 2, ry = along_y.size() / 2;
  std::vector<double> padded(width + 2 * rx), sum(width);
  for (uint32_t y = 0; y < height; ++y) {
    for (size_t i = 0; i < padded.size(); ++i)
      padded[i] = static_cast<double>(plane.at(static_cast<uint32_t>(std::clamp(i, rx, rx + width - 1) - rx), y));
    std::fill(sum.begin(), sum.end(), 0.0);
    for (size_t k = 0; k < along_x.size(); ++k)
      for (uint32_t x = 0; x < width; ++x) sum[x] += along_x[k] * padded[x + k];
    for (uint32_t x = 0; x < width; ++x) rows.at(x, y) = static_cast<float>(sum[x]);
  }
  for (uint32_t y = 0; y < height; ++y) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (size_t k = 0; k < along_y.size(); ++k) {
      const float* row = &rows.values[(std::clamp(y + k, ry, ry + height - 1) - ry) * width];
      for (uint32_t x = 0; x < width; ++x) sum[x] += along_y[k] * static_cast<double>(row[x]);
    }
    for (uint32_t x = 0; x < width; ++x) out.at(x, y) = static_cast<float>(sum[x]);
  }
  return out;
}

std::vector<double> gaussian_weights(double sigma, int radius) {
  std::vector<double> weights;
  for (int x = -radius; x <= radius; ++x) weights.push_back(std::exp(-x * x / (2.0 * sigma * sigma)));
  return weights;
}

double masked_mean(std::span<const float> values, const PixelMask& mask) {
  double sum = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < values.size(); ++i)
    if (mask[i]) {
      sum += static_cast<double>(values[i]);
      ++count;
    }
  return sum / static_cast<double>(count);
}

}  // namespace nepho
