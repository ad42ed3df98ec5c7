#include "compare/compare_images.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "compare/flip.h"
#include "compare/heatmap.h"
#include "compare/image_measures.h"

namespace nepho {

namespace {

using Rgb = std::vector<glm::vec3>;

std::string names_of(const ImageBuffer& image) {
  constexpr size_t kMost = 8;
  std::vector<std::string> names;
  for (const ImageChannel& c : image.channels) {
    if (names.size() == kMost) {
      names.push_back("...");
      break;
    }
    names.push_back(c.name);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::optional<Rgb> find_rgb(const ImageBuffer& image, const std::string& layer) {
  std::array<const ImageChannel*, 3> channels{};
  for (size_t c = 0; c < 3; ++c) channels[c] = image.find(layer + "RGB"[c]);
  if (!channels[0] || !channels[1] || !channels[2]) return std::nullopt;
  Rgb rgb(size_t{image.width} * image.height);
  for (size_t i = 0; i < rgb.size(); ++i)
    rgb[i] = glm::vec3(channels[0]->values[i], channels[1]->values[i], channels[2]->values[i]);
  return rgb;
}

Rgb require_rgb(const ImageBuffer& image, const std::string& name) {
  std::optional<Rgb> rgb = find_rgb(image, "");
  if (!rgb)
    throw fail(ErrorKind::input, "{}: has no channels R, G, B (found: {}); compare pictures that nepho render wrote",
               name, names_of(image));
  const auto bad = std::count_if(rgb->begin(), rgb->end(), [](const glm::vec3& v) {
    return !std::isfinite(v.r) || !std::isfinite(v.g) || !std::isfinite(v.b);
  });
  if (bad > 0)
    throw fail(ErrorKind::input,
               "{}: {} of {} pixels are NaN or infinite in R, G or B; nothing can be measured with them", name, bad,
               rgb->size());
  return std::move(*rgb);
}

PixelMask make_mask(const ImageBuffer& b, const CompareOptions& options) {
  PixelMask mask(size_t{b.width} * b.height, 1);
  if (options.mask == CompareMask::none) return mask;
  const ImageChannel* const transmittance = b.find("cloud.transmittance");
  if (!transmittance)
    throw fail(
        ErrorKind::input,
        "{}: has no layer cloud.transmittance, which --mask cloud needs; render it without --aov, or with cloud in it",
        options.name_b);
  for (size_t i = 0; i < mask.size(); ++i) {
    if (std::isnan(transmittance->values[i]))
      throw fail(ErrorKind::input, "{}: cloud.transmittance has NaN; render it again", options.name_b);
    mask[i] = transmittance->values[i] < 0.99f;
  }
  if (std::find(mask.begin(), mask.end(), 1) == mask.end())
    throw fail(ErrorKind::input, "{}: no pixel has cloud (cloud.transmittance < 0.99); leave --mask cloud out",
               options.name_b);
  return mask;
}

std::vector<double> luminances(const Rgb& rgb) {
  std::vector<double> out;
  out.reserve(rgb.size());
  for (const glm::vec3& v : rgb)
    out.push_back(0.2126 * static_cast<double>(v.r) + 0.7152 * static_cast<double>(v.g) +
                  0.0722 * static_cast<double>(v.b));
  return out;
}

std::optional<double> noise_of(const ImageBuffer& image, const std::string& name, const std::vector<double>& luminance,
                               const PixelMask& mask) {
  const std::optional<Rgb> variance = find_rgb(image, "variance.");
  if (!variance) return std::nullopt;
  size_t bad = 0;
  for (size_t i = 0; i < mask.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const float v = (*variance)[i][c];
      bad += mask[i] && !(v >= 0.0f && std::isfinite(v));
    }
  if (bad > 0)
    throw fail(ErrorKind::input, "{}: {} values of variance.R/G/B are negative, NaN or infinite; render it again", name,
               bad);
  return relative_noise(luminance, *variance, mask);
}

}  // namespace

Comparison compare_images(const ImageBuffer& a, const ImageBuffer& b, const CompareOptions& options) {
  if (a.width != b.width || a.height != b.height)
    throw fail(ErrorKind::input, "{} has {}x{} pixels and {} {}x{}; only pictures of one size can be compared",
               options.name_a, a.width, a.height, options.name_b, b.width, b.height);
  const Rgb rgb_a = require_rgb(a, options.name_a), rgb_b = require_rgb(b, options.name_b);
  const PixelMask mask = make_mask(b, options);
  const std::vector<double> y_a = luminances(rgb_a), y_b = luminances(rgb_b);

  Comparison out;
  out.pixels = static_cast<size_t>(std::count(mask.begin(), mask.end(), 1));
  const LinearMeasures linear = linear_measures(y_a, y_b, mask);
  out.rmse = linear.rmse;
  out.mean_relative_error = linear.mean_relative_error;
  out.bias = linear.bias;
  out.noise_of_b = noise_of(b, options.name_b, y_b, mask);
  if (out.noise_of_b && noise_of(a, options.name_a, y_a, mask)) {
    const Agreement z = agreement(y_a, y_b, *find_rgb(a, "variance."), *find_rgb(b, "variance."), mask);
    out.within_3_sigma = z.within_3_sigma;
    out.largest_z = z.largest_z;
  }

  out.exposure_ev100 =
      options.exposure_ev100 ? *options.exposure_ev100 : metered_ev100(b.width, b.height, rgb_b, options.limits);
  const ToneSettings tone{
      .ev100 = out.exposure_ev100, .curve = options.tone_curve, .white_balance = options.white_balance};
  const Rgb shown_a = display_from_linear(rgb_a, tone), shown_b = display_from_linear(rgb_b, tone);
  out.psnr_db = psnr_db(shown_a, shown_b, mask);
  out.ssim = ssim(b.width, b.height, shown_a, shown_b, mask);
  out.flip = masked_mean(flip_map(b.width, b.height, shown_a, shown_b).values, mask);
  if (options.heatmap) out.heatmap_rgb = error_heatmap(y_a, y_b, mask);
  return out;
}

}  // namespace nepho
