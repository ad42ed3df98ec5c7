#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "compare/plane.h"

namespace nepho {

// Measures between a picture A and its reference B over the pixels of a mask, which has at least one (docs/compare.md).

/// Of luminances, cd/m2.
struct LinearMeasures {
  double rmse = 0.0;                          ///< sqrt(mean (A - B)^2), cd/m2
  std::optional<double> mean_relative_error;  ///< sum |A - B| / sum B; absent when the sum of B is not positive
  std::optional<double> bias;                 ///< sum (A - B) / sum B; as above
};
LinearMeasures linear_measures(std::span<const double> a, std::span<const double> b, const PixelMask& mask);

/// Peak signal to noise ratio of display values, peak 1, dB: -10 log10 of the mean square over pixels and their three
/// channels. Absent (infinite) when they are equal.
std::optional<double> psnr_db(std::span<const glm::vec3> a, std::span<const glm::vec3> b, const PixelMask& mask);

/// Structural similarity of Wang et al. 2004 on the Rec. 709 luma of display values, 1 when equal: Gaussian window of
/// 11 x 11 pixels, sigma 1.5, K1 = 0.01, K2 = 0.03, range 1. Mean over those pixels of the mask whose whole window lies
/// in the picture, as in the authors' program; absent when there are none.
std::optional<double> ssim(uint32_t width, uint32_t height, std::span<const glm::vec3> a, std::span<const glm::vec3> b,
                           const PixelMask& mask);

/// The relative standard error of luminance that 95 % of the mask's pixels do not exceed (nearest rank). Of one pixel
/// it is (sum of w_c sqrt(variance_c)) / Y: the channels of one path go up and down together, so their errors add.
/// Black pixels without variance have none. Absent when it is not finite: more than 5 % of the pixels are noisy and
/// black. `luminance`, cd/m2; `variance`: of the mean of R, G, B, (cd/m2)^2, >= 0.
std::optional<double> relative_noise(std::span<const double> luminance, std::span<const glm::vec3> variance,
                                     const PixelMask& mask);

/// How two noisy pictures of the same expectation should differ: Z = (A - B) / sqrt(their variances' sum), of luminance.
struct Agreement {
  double within_3_sigma = 0.0;  ///< share of the pixels with |Z| <= 3; 0.9973 of normal errors
  double largest_z = 0.0;
};
/// Over the mask's pixels; those where neither picture has variance count as within when they are equal. Variances as
/// relative_noise() takes them.
Agreement agreement(std::span<const double> a, std::span<const double> b, std::span<const glm::vec3> variance_a,
                    std::span<const glm::vec3> variance_b, const PixelMask& mask);

}  // namespace nepho
