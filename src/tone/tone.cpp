#include "tone/tone.h"

#include "base/error.h"
#include "common/tonemap.h"
#include "render/exposure_meter.h"

namespace nepho {

uint32_t tone_curve_id(const std::string& name) {
  if (name == "linear") return shared::kToneLinear;
  if (name == "reinhard") return shared::kToneReinhard;
  if (name == "aces") return shared::kToneAces;
  if (name == "agx") return shared::kToneAgx;
  throw fail(ErrorKind::usage, "tone_curve: '{}' is not one of aces, agx, reinhard, linear", name);
}

double metered_ev100(uint32_t width, uint32_t height, std::span<const glm::vec3> rgb, const MeterLimits& limits) {
  NEPHO_ASSERT_OP(rgb.size(), ==, size_t{width} * height);
  const uint32_t stride = shared::meter_stride(width, height);
  std::vector<uint32_t> counts(shared::kHistogramBins, 0);
  for (uint32_t y = stride / 2; y < height; y += stride)
    for (uint32_t x = stride / 2; x < width; x += stride) {
      const float l = shared::luminance(rgb[size_t{y} * width + x]);
      if (shared::meter_counts(l)) ++counts[shared::meter_bin(l)];
    }
  const std::vector<float> bins(counts.begin(), counts.end());
  return static_cast<double>(shared::metered_ev100(bins.data(), static_cast<float>(limits.min_ev100),
                                                   static_cast<float>(limits.max_ev100),
                                                   static_cast<float>(limits.compensation_ev)));
}

std::vector<glm::vec3> display_from_linear(std::span<const glm::vec3> rgb, const ToneSettings& settings) {
  const float exposure = shared::exposure_from_ev100(static_cast<float>(settings.ev100));
  std::vector<glm::vec3> display;
  display.reserve(rgb.size());
  for (const glm::vec3& v : rgb) {
    // Far beyond white; more would overflow in the curves.
    const glm::vec3 exposed = glm::clamp(v * exposure, -1.0e12f, 1.0e12f);
    const glm::vec3 mapped = shared::tone_map(settings.white_balance * exposed, settings.curve);
    display.emplace_back(shared::srgb_from_linear(mapped.r), shared::srgb_from_linear(mapped.g),
                         shared::srgb_from_linear(mapped.b));
  }
  return display;
}

}  // namespace nepho
