#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// Number of reductions of a width x height raster: 0 .. n-1, where at the last the whole raster fits one block.
uint32_t reduction_count(uint32_t width, uint32_t height);

/// One block of a reduced raster, and the source pixels that it averages.
struct BlockWindow {
  uint32_t x0 = 0, y0 = 0;                 ///< source px, top left corner
  uint32_t src_width = 0, src_height = 0;  ///< source px
  uint32_t width = 0, height = 0;          ///< px of the block, 1..Raster::kBlockSize
  uint32_t factor = 1;                     ///< source px per block px and side, 2^reduction
};

/// The window of block (bx, by); none when the block lies outside the raster or 2^reduction overflows.
std::optional<BlockWindow> block_window(const RasterInfo& info, uint32_t reduction, uint32_t bx, uint32_t by);

/// Averages factor x factor pixels into one, counting only the valid ones: what Raster::read_block promises. Sums are
/// in double and in a fixed order, so that the result does not depend on how the rows were read.
class BlockAverager {
 public:
  /// Input rows have `src_width` pixels of `bands` values; output is ceil(src_width / factor) x ceil(src_height /
  /// factor).
  BlockAverager(uint32_t src_width, uint32_t src_height, uint32_t bands, uint32_t factor);
  /// The next row from the top: src_width * bands values and src_width flags.
  void add_row(std::span<const float> values, std::span<const uint8_t> valid);
  RasterBlock finish() &&;

 private:
  void flush();
  uint32_t src_width_, bands_, factor_, rows_ = 0;
  std::vector<double> sums_;
  std::vector<uint32_t> counts_;
  RasterBlock block_;
  uint32_t out_row_ = 0;
};

}  // namespace nepho
