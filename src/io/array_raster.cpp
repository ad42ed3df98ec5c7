#include "io/array_raster.h"

#include <cmath>

#include "io/raster_grid.h"

namespace nepho {

ArrayRaster::ArrayRaster(RasterInfo info, std::vector<float> values, std::vector<uint8_t> valid)
    : info_(std::move(info)), values_(std::move(values)), valid_(std::move(valid)) {
  const size_t pixels = size_t{info_.width} * info_.height;
  NEPHO_ASSERT_OP(values_.size(), ==, pixels * info_.bands);
  if (valid_.empty()) valid_.assign(pixels, 1);
  NEPHO_ASSERT_OP(valid_.size(), ==, pixels);
  for (size_t i = 0; i < values_.size(); ++i)
    if (!std::isfinite(values_[i])) valid_[i / info_.bands] = 0;
}

uint32_t ArrayRaster::reductions() const { return reduction_count(info_.width, info_.height); }

Result<RasterBlock> ArrayRaster::read_block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  const auto window = block_window(info_, reduction, bx, by);
  if (!window)
    return Result<RasterBlock>::failed(
        fmt::format("{}: has no block ({}, {}) at reduction {}", info_.path, bx, by, reduction));
  BlockAverager averager(window->src_width, window->src_height, info_.bands, window->factor);
  for (uint32_t y = 0; y < window->src_height; ++y) {
    const size_t first = size_t{window->y0 + y} * info_.width + window->x0;
    averager.add_row(std::span(values_).subspan(first * info_.bands, size_t{window->src_width} * info_.bands),
                     std::span(valid_).subspan(first, window->src_width));
  }
  return std::move(averager).finish();
}

}  // namespace nepho
