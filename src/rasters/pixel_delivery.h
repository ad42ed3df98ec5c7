#pragma once
#include <cstddef>
#include <cstdint>

#include "rasters/band_plan.h"

namespace nepho {

/// One row of raw numbers: band b of pixel x is raw[b * stride + x].
struct BandView {
  const float* raw;
  const uint8_t* mask;
  size_t stride;
};

/// Turns a row of a dataset's numbers into what RasterBlock holds, by its plan.
void deliver_row(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid);

}  // namespace nepho
