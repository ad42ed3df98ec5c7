#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace nepho {

/// One number for each pixel, row 0 on top.
struct Plane {
  uint32_t width = 0, height = 0;
  std::vector<float> values;
  Plane(uint32_t w, uint32_t h) : width(w), height(h), values(size_t{w} * h, 0.0f) {}
  float& at(uint32_t x, uint32_t y) { return values[size_t{y} * width + x]; }
  float at(uint32_t x, uint32_t y) const { return values[size_t{y} * width + x]; }
};

/// Which pixels count, 0 or 1 each.
using PixelMask = std::vector<uint8_t>;

/// The plane weighted by along_x[i] * along_y[j] around each pixel (correlation; odd numbers of weights, the middle one
/// at the pixel itself). Beyond the edges the nearest pixel counts.
Plane filtered(const Plane& plane, std::span<const double> along_x, std::span<const double> along_y);

/// exp(-x^2 / (2 sigma^2)) for x = -radius..radius, not normalised.
std::vector<double> gaussian_weights(double sigma, int radius);

/// Mean over the mask; the mask has at least one pixel.
double masked_mean(std::span<const float> values, const PixelMask& mask);

}  // namespace nepho
