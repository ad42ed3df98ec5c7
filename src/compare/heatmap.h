#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "compare/plane.h"

namespace nepho {

/// Colour of a signed relative error: ColorBrewer's RdBu, from dark blue (-0.5 and below: too dark) through near white
/// (0) to dark red (0.5 and above: too bright). sRGB, 8 bits.
std::array<uint8_t, 3> error_colour(double relative_error);

/// A picture of (A - B) / (B + 0.05 mean of B) in error_colour(), 8-bit sRGB, three values a pixel; pixels that the
/// mask leaves out are grey. The mean is over the mask; it keeps black pixels from dividing by nothing. `a`, `b`:
/// luminances, cd/m2.
std::vector<uint8_t> error_heatmap(std::span<const double> a, std::span<const double> b, const PixelMask& mask);

}  // namespace nepho
