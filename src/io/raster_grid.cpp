#include "io/raster_grid.h"

#include <algorithm>

namespace nepho {

namespace {
constexpr uint32_t kMaxReduction = 30;

uint32_t ceil_div(uint32_t a, uint32_t b) { return a / b + (a % b != 0 ? 1u : 0u); }
}  // namespace

uint32_t reduction_count(uint32_t width, uint32_t height) {
  uint32_t count = 1;
  while (count <= kMaxReduction && ceil_div(std::max(width, height), 1u << (count - 1)) > Raster::kBlockSize) ++count;
  return count;
}

std::optional<BlockWindow> block_window(const RasterInfo& info, uint32_t reduction, uint32_t bx, uint32_t by) {
  if (reduction > kMaxReduction) return std::nullopt;
  const uint64_t side = uint64_t{Raster::kBlockSize} << reduction;
  const uint64_t x0 = bx * side, y0 = by * side;
  if (x0 >= info.width || y0 >= info.height) return std::nullopt;
  BlockWindow w;
  w.factor = 1u << reduction;
  w.x0 = static_cast<uint32_t>(x0);
  w.y0 = static_cast<uint32_t>(y0);
  w.src_width = static_cast<uint32_t>(std::min<uint64_t>(side, info.width - x0));
  w.src_height = static_cast<uint32_t>(std::min<uint64_t>(side, info.height - y0));
  w.width = ceil_div(w.src_width, w.factor);
  w.height = ceil_div(w.src_height, w.factor);
  return w;
}

BlockAverager::BlockAverager(uint32_t src_width, uint32_t src_height, uint32_t bands, uint32_t factor)
    : src_width_(src_width), bands_(bands), factor_(factor) {
  block_.width = ceil_div(src_width, factor);
  block_.height = ceil_div(src_height, factor);
  block_.values.resize(size_t{block_.width} * block_.height * bands);
  block_.valid.resize(size_t{block_.width} * block_.height);
  sums_.resize(size_t{block_.width} * bands);
  counts_.resize(block_.width);
}

void BlockAverager::add_row(std::span<const float> values, std::span<const uint8_t> valid) {
  if (factor_ == 1) {
    const size_t first = size_t{out_row_++} * src_width_;
    std::copy_n(values.begin(), size_t{src_width_} * bands_,
                block_.values.begin() + static_cast<std::ptrdiff_t>(first * bands_));
    std::transform(valid.begin(), valid.begin() + src_width_, block_.valid.begin() + static_cast<std::ptrdiff_t>(first),
                   [](uint8_t v) { return static_cast<uint8_t>(v != 0); });
    return;
  }
  uint32_t x = 0;
  for (uint32_t out = 0; out < block_.width; ++out) {
    double* const sums = sums_.data() + size_t{out} * bands_;
    for (const uint32_t end = std::min(src_width_, x + factor_); x < end; ++x) {
      if (!valid[x]) continue;
      ++counts_[out];
      for (uint32_t b = 0; b < bands_; ++b) sums[b] += static_cast<double>(values[size_t{x} * bands_ + b]);
    }
  }
  if (++rows_ == factor_) flush();
}

void BlockAverager::flush() {
  const size_t first = size_t{out_row_} * block_.width;
  for (uint32_t x = 0; x < block_.width; ++x) {
    if (counts_[x] == 0) continue;
    block_.valid[first + x] = 1;
    for (uint32_t b = 0; b < bands_; ++b)
      block_.values[(first + x) * bands_ + b] =
          static_cast<float>(sums_[size_t{x} * bands_ + b] / static_cast<double>(counts_[x]));
  }
  std::fill(sums_.begin(), sums_.end(), 0.0);
  std::fill(counts_.begin(), counts_.end(), 0u);
  rows_ = 0;
  ++out_row_;
}

RasterBlock BlockAverager::finish() && {
  if (rows_ > 0) flush();
  return std::move(block_);
}

}  // namespace nepho
