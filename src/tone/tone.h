#pragma once
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace nepho {

/// The constant of shaders/common/tonemap.h for a tone curve's name: aces, agx, reinhard, linear. Throws Error(usage).
uint32_t tone_curve_id(const std::string& name);

/// What bounds the automatic exposure: RenderParams has the same members.
struct MeterLimits {
  double min_ev100 = -8.0;
  double max_ev100 = 17.0;
  double compensation_ev = 0.0;  ///< brighter by so many stops
};

/// EV100 that the renderer's automatic exposure gives a still picture (docs/exposure.md), from linear Rec. 709 in
/// cd/m2, row by row: the same histogram over the same grid of pixels, and the same function, as on the GPU.
double metered_ev100(uint32_t width, uint32_t height, std::span<const glm::vec3> rgb, const MeterLimits& limits = {});

/// How linear pictures become display values.
struct ToneSettings {
  double ev100 = 0.0;
  uint32_t curve = 0;                         ///< tone_curve_id()
  glm::mat3 white_balance = glm::mat3(1.0f);  ///< rec709_white_balance()
};

/// sRGB-encoded display values, 0..1, from linear Rec. 709 in cd/m2: what a PNG picture of `nepho render` rounds, by
/// the exact curves of tonemap.h, without dither.
std::vector<glm::vec3> display_from_linear(std::span<const glm::vec3> rgb, const ToneSettings& settings);

}  // namespace nepho
