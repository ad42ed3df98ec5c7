#pragma once
#include <vector>

#include "io/image_buffer.h"
#include "render/output_layers.h"
#include "render/reference_shared.h"

namespace nepho {

/// Relative standard error of the luminance that 95 % of the pixels do not exceed; black pixels have none. 1 with fewer
/// than two paths a pixel.
double noise_of(const std::vector<shared::PixelSums>& sums);

/// Sums of two sets of paths for the same pixels as one (Chan, Golub and LeVeque 1979).
std::vector<shared::PixelSums> merged(const std::vector<shared::PixelSums>& a, const std::vector<shared::PixelSums>& b);

/// The sums that a written picture came from. Throws Error(input), with `file` in front, for a picture of another size
/// or without its layers.
std::vector<shared::PixelSums> sums_of_picture(const ImageBuffer& picture, Extent2D extent);

/// Fills radiance, cloud, cloud_info and variance.
void put_sums(const std::vector<shared::PixelSums>& sums, FrameReadback& to);

}  // namespace nepho
