#include "rasters/pixel_delivery.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nepho {

namespace {

/// Voids that a file does not declare are no heights: the one of 16-bit elevation, and what no place on Earth reaches.
constexpr float kVoid = -32768.0f;
constexpr float kLargestHeight_m = 20000.0f;

void deliver_heights(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const auto exaggeration = static_cast<float>(plan.exaggeration);
  const float* const alpha = plan.alpha ? in.raw + in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x) {
    const float raw = in.raw[x], height_m = raw * scale + offset;
    // NaN fails the comparison of heights.
    const bool good =
        in.mask[x] && raw != kVoid && std::abs(height_m) < kLargestHeight_m && (!alpha || alpha[x] > 0.0f);
    valid[x] = good ? 1 : 0;
    out[x] = good ? height_m * exaggeration : 0.0f;
  }
}

void deliver_palette(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  for (uint32_t x = 0; x < width; ++x) {
    const auto entry = static_cast<size_t>(std::max(in.raw[x], 0.0f));
    const bool good = entry < plan.palette.size() && plan.palette[entry][3] > 0.0f;
    const std::array<float, 4> rgba = good ? plan.palette[entry] : std::array<float, 4>{};
    std::copy(rgba.begin(), rgba.end(), out + size_t{x} * 4);
    out[size_t{x} * 4 + 3] *= static_cast<float>(plan.opacity);
    valid[x] = good ? 1 : 0;
  }
}

void deliver_colors(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const auto alpha_scale = static_cast<float>(255.0 / plan.alpha_max), opacity = static_cast<float>(plan.opacity);
  const size_t g = plan.colors.size() == 3 ? in.stride : 0, b = 2 * g;
  const float* const alpha = plan.alpha ? in.raw + plan.colors.size() * in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x, out += 4) {
    const float* const raw = in.raw + x;
    const bool good = in.mask[x] && std::isfinite(raw[0] + raw[g] + raw[b]) && (!alpha || alpha[x] > 0.0f);
    valid[x] = good ? 1 : 0;
    out[0] = good ? std::clamp(raw[0] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[1] = good ? std::clamp(raw[g] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[2] = good ? std::clamp(raw[b] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[3] = !good ? 0.0f : opacity * (alpha ? std::min(alpha[x] * alpha_scale, 255.0f) : 255.0f);
  }
}

void deliver_weather(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  constexpr float kSlack = 0.02f;  // packing and interpolation overshoot; anything further is no cover
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const auto opacity_scale = static_cast<float>(plan.opacity_scale);
  const bool with_opacity = plan.opacity_scale > 0.0;
  const size_t values = plan.colors.size() - (with_opacity ? 1 : 0), bands = static_cast<size_t>(plan.weather);
  const float* const alpha = plan.alpha ? in.raw + plan.colors.size() * in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x, out += bands) {
    bool good = in.mask[x] && (!alpha || alpha[x] > 0.0f);
    for (size_t b = 0; b < values; ++b) {
      const float v = in.raw[b * in.stride + x] * scale + offset;
      good = good && v >= -kSlack && v <= 1.0f + kSlack;  // NaN fails
      const float opacity = with_opacity ? in.raw[values * in.stride + x] * opacity_scale : 1.0f;
      out[b] = std::clamp(v, 0.0f, 1.0f) * std::clamp(opacity, 0.0f, 1.0f);
    }
    for (size_t b = values; b < bands; ++b) out[b] = 0.0f;
    valid[x] = good ? 1 : 0;
    if (!good) std::fill_n(out, bands, 0.0f);
  }
}

void deliver_weather_palette(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto bands = static_cast<size_t>(plan.weather);
  for (uint32_t x = 0; x < width; ++x, out += bands) {
    const auto entry = static_cast<size_t>(std::max(in.raw[x], 0.0f));
    const bool good = entry < plan.palette.size() && !std::isnan(plan.palette[entry][0]);
    for (size_t b = 0; b < bands; ++b) out[b] = good ? plan.palette[entry][b] : 0.0f;
    valid[x] = good ? 1 : 0;
  }
}

}  // namespace

void deliver_row(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  if (plan.elevation)
    deliver_heights(plan, in, width, out, valid);
  else if (plan.weather)
    (plan.palette.empty() ? deliver_weather : deliver_weather_palette)(plan, in, width, out, valid);
  else if (!plan.palette.empty())
    deliver_palette(plan, in, width, out, valid);
  else
    deliver_colors(plan, in, width, out, valid);
}

}  // namespace nepho
