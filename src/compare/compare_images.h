#pragma once
#include <glm/mat3x3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/image_buffer.h"
#include "tone/tone.h"

namespace nepho {

/// Which pixels of a comparison count.
enum class CompareMask {
  none,   ///< all
  cloud,  ///< those that clouds dim in the reference: cloud.transmittance < 0.99
};

struct CompareOptions {
  std::string name_a = "A", name_b = "B";  ///< in messages
  CompareMask mask = CompareMask::none;
  std::optional<double> exposure_ev100 = {};  ///< of both pictures; without: metered on B
  MeterLimits limits = {};                    ///< of that meter
  uint32_t tone_curve = 0;                    ///< tone_curve_id()
  glm::mat3 white_balance = glm::mat3(1.0f);  ///< rec709_white_balance()
  bool heatmap = false;
};

/// What docs/compare.md explains. Members of one name there and here.
struct Comparison {
  // Linear luminance, cd/m2.
  double rmse = 0.0;
  std::optional<double> mean_relative_error, bias, noise_of_b;
  std::optional<double> within_3_sigma, largest_z;  ///< Agreement, where both pictures have variances
  // Tone mapped, with one exposure for both.
  std::optional<double> psnr_db, ssim;
  double flip = 0.0;
  size_t pixels = 0;  ///< of the mask
  double exposure_ev100 = 0.0;
  std::vector<uint8_t> heatmap_rgb;  ///< error_heatmap(), if it was asked for
};

/// Measures how far picture A is from the reference B: channels R, G, B in cd/m2. Throws Error(input) with the
/// picture's name: no such channels, NaN or infinite values, sizes that differ, no cloud.transmittance for the mask, an
/// empty mask, variances that cannot be.
Comparison compare_images(const ImageBuffer& a, const ImageBuffer& b, const CompareOptions& options);

}  // namespace nepho
