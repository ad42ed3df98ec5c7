#include "compare/image_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/tonemap.h"

namespace nepho {

LinearMeasures linear_measures(std::span<const double> a, std::span<const double> b, const PixelMask& mask) {
  double squares = 0.0, absolute = 0.0, difference = 0.0, reference = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!mask[i]) continue;
    const double d = a[i] - b[i];
    squares += d * d;
    absolute += std::abs(d);
    difference += d;
    reference += b[i];
    ++count;
  }
  LinearMeasures out{.rmse = std::sqrt(squares / static_cast<double>(count)), .mean_relative_error = {}, .bias = {}};
  if (reference > 0.0) {
    out.mean_relative_error = absolute / reference;
    out.bias = difference / reference;
  }
  return out;
}

std::optional<double> psnr_db(std::span<const glm::vec3> a, std::span<const glm::vec3> b, const PixelMask& mask) {
  double squares = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!mask[i]) continue;
    const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]);
    squares += glm::dot(d, d);
    count += 3;
  }
  if (squares == 0.0) return std::nullopt;
  return -10.0 * std::log10(squares / static_cast<double>(count));
}

std::optional<double> ssim(uint32_t width, uint32_t height, std::span<const glm::vec3> a, std::span<const glm::vec3> b,
                           const PixelMask& mask) {
  constexpr uint32_t kRadius = 5;
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  if (width <= 2 * kRadius || height <= 2 * kRadius) return std::nullopt;
  std::vector<double> window = gaussian_weights(1.5, kRadius);
  double total = 0.0;
  for (const double w : window) total += w;
  for (double& w : window) w /= total;

  const auto smooth = [&](const auto& value) {
    Plane plane(width, height);
    for (size_t i = 0; i < plane.values.size(); ++i) plane.values[i] = value(i);
    return filtered(plane, window, window);
  };
  const auto luma = [](const glm::vec3& v) { return shared::luminance(v); };
  const Plane mean_a = smooth([&](size_t i) { return luma(a[i]); });
  const Plane mean_b = smooth([&](size_t i) { return luma(b[i]); });
  const Plane square_a = smooth([&](size_t i) { return luma(a[i]) * luma(a[i]); });
  const Plane square_b = smooth([&](size_t i) { return luma(b[i]) * luma(b[i]); });
  const Plane product = smooth([&](size_t i) { return luma(a[i]) * luma(b[i]); });

  double sum = 0.0;
  size_t count = 0;
  for (uint32_t y = kRadius; y < height - kRadius; ++y)
    for (uint32_t x = kRadius; x < width - kRadius; ++x) {
      if (!mask[size_t{y} * width + x]) continue;
      const auto at = [x, y](const Plane& p) { return static_cast<double>(p.at(x, y)); };
      const double ma = at(mean_a), mb = at(mean_b);
      const double var_a = at(square_a) - ma * ma, var_b = at(square_b) - mb * mb, covar = at(product) - ma * mb;
      sum += (2.0 * ma * mb + c1) * (2.0 * covar + c2) / ((ma * ma + mb * mb + c1) * (var_a + var_b + c2));
      ++count;
    }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

std::optional<double> relative_noise(std::span<const double> luminance, std::span<const glm::vec3> variance,
                                     const PixelMask& mask) {
  std::vector<double> errors;
  for (size_t i = 0; i < luminance.size(); ++i) {
    if (!mask[i]) continue;
    const glm::dvec3 sigma = glm::sqrt(glm::dvec3(variance[i]));
    const double error = glm::dot(sigma, glm::dvec3(0.2126, 0.7152, 0.0722));
    if (error == 0.0)
      errors.push_back(0.0);
    else
      errors.push_back(luminance[i] > 0.0 ? error / luminance[i] : std::numeric_limits<double>::infinity());
  }
  const size_t rank = static_cast<size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank), errors.end());
  if (!std::isfinite(errors[rank])) return std::nullopt;
  return errors[rank];
}

Agreement agreement(std::span<const double> a, std::span<const double> b, std::span<const glm::vec3> variance_a,
                    std::span<const glm::vec3> variance_b, const PixelMask& mask) {
  // The channels of one path are one but for their weights.
  const auto error = [](const glm::vec3& v) {
    return 0.2126 * std::sqrt(static_cast<double>(v.r)) + 0.7152 * std::sqrt(static_cast<double>(v.g)) +
           0.0722 * std::sqrt(static_cast<double>(v.b));
  };
  Agreement out;
  size_t count = 0, within = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    if (!mask[i]) continue;
    ++count;
    const double sigma = std::hypot(error(variance_a[i]), error(variance_b[i])), apart = std::abs(a[i] - b[i]);
    // Half a millionth is what floats of one light differ by between devices.
    const double z = sigma > 5e-7 * std::abs(b[i]) ? apart / sigma : (apart <= 5e-6 * std::abs(b[i]) ? 0.0 : 1e9);
    within += z <= 3.0;
    out.largest_z = std::max(out.largest_z, z);
  }
  out.within_3_sigma = static_cast<double>(within) / static_cast<double>(std::max<size_t>(count, 1));
  return out;
}

}  // namespace nepho
