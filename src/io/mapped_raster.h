#pragma once
#include <array>
#include <memory>

#include "io/raster.h"

namespace nepho {

/// Colours of an imagery raster put through a curve: 256 values, 0..255, for the colours 0..255 (between them linear).
/// Alpha and the georeference stay as they are.
std::shared_ptr<Raster> make_mapped_imagery(std::shared_ptr<Raster> source, const std::array<float, 256>& curve);

/// The curve that turns sRGB pictures into albedo = offset + scale * linear value: for pictures that were stretched to
/// please, such as the Blue Marble, whose forests are black and whose deserts are white. Before that their numbers v in
/// 0..1 become v^(1/gamma): above 1 lightens the middle tones.
std::array<float, 256> albedo_curve(float offset, float scale, float gamma = 1.0f);

}  // namespace nepho
