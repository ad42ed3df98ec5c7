#include "compare/heatmap.h"

#include <algorithm>
#include <cmath>

namespace nepho {

std::array<uint8_t, 3> error_colour(double relative_error) {
  // ColorBrewer 2.0, 11-class RdBu, from blue to red.
  static constexpr uint8_t kStops[11][3] = {{5, 48, 97},     {33, 102, 172},  {67, 147, 195},  {146, 197, 222},
                                            {209, 229, 240}, {247, 247, 247}, {253, 219, 199}, {244, 165, 130},
                                            {214, 96, 77},   {178, 24, 43},   {103, 0, 31}};
  const double x = (std::clamp(relative_error, -0.5, 0.5) + 0.5) * 10.0;
  const size_t i = std::min<size_t>(static_cast<size_t>(x), 9);
  const double t = x - static_cast<double>(i);
  std::array<uint8_t, 3> out{};
  for (size_t c = 0; c < 3; ++c)
    out[c] = static_cast<uint8_t>(std::lround((1.0 - t) * kStops[i][c] + t * kStops[i + 1][c]));
  return out;
}

std::vector<uint8_t> error_heatmap(std::span<const double> a, std::span<const double> b, const PixelMask& mask) {
  double sum = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < b.size(); ++i)
    if (mask[i]) {
      sum += b[i];
      ++count;
    }
  const double floor = 0.05 * sum / static_cast<double>(std::max<size_t>(count, 1));
  std::vector<uint8_t> rgb;
  rgb.reserve(3 * a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    std::array<uint8_t, 3> colour = {128, 128, 128};
    if (mask[i]) {
      const double difference = a[i] - b[i], scale = std::max(b[i] + floor, 0.0);
      // Where B is black everywhere, any light is too much.
      colour = error_colour(difference == 0.0 ? 0.0
                            : scale > 0.0     ? difference / scale
                                              : std::copysign(1.0, difference));
    }
    rgb.insert(rgb.end(), colour.begin(), colour.end());
  }
  return rgb;
}

}  // namespace nepho
