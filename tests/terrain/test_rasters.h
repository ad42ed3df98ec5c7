#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "io/raster.h"
#include "io/raster_grid.h"

namespace nepho::test {

/// A raster of any size whose pixel (x, y) is 2 x + 3 y + 1 (times a factor), so that the mean of any rectangle is
/// known. What it does before it delivers a block can be said.
class PlaneRaster final : public Raster {
 public:
  PlaneRaster(uint32_t width, uint32_t height, std::string name = "plane") {
    info_.path = std::move(name);
    info_.width = width;
    info_.height = height;
    info_.bounds = {10.0, 20.0, 10.0 + 0.001 * width, 20.0 + 0.001 * height};
  }
  /// The mean of the pixels (x, y) of a reduction, cut at the edges.
  double mean(uint32_t reduction, uint32_t x, uint32_t y) const {
    const uint32_t step = 1u << reduction;
    const double x1 = std::min((x + 1) * step, info_.width) - 1.0, y1 = std::min((y + 1) * step, info_.height) - 1.0;
    return value_scale * (2.0 * (x * step + x1) / 2.0 + 3.0 * (y * step + y1) / 2.0 + 1.0);
  }
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return reduction_count(info_.width, info_.height); }
  uint32_t pyramid_level(uint32_t reduction) const override { return has_pyramid && reduction > 3 ? reduction - 3 : 0; }
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override {
    const uint64_t number = ++reads;
    if (before && !before(reduction, bx, by, number)) return Result<RasterBlock>::failed(info_.path + ": broken");
    const uint32_t step = 1u << reduction;
    const uint32_t w = (info_.width + step - 1) / step, h = (info_.height + step - 1) / step;
    RasterBlock block{.width = std::min(kBlockSize, w - bx * kBlockSize),
                      .height = std::min(kBlockSize, h - by * kBlockSize),
                      .values = {},
                      .valid = {}};
    for (uint32_t y = 0; y < block.height; ++y)
      for (uint32_t x = 0; x < block.width; ++x)
        block.values.push_back(static_cast<float>(mean(reduction, bx * kBlockSize + x, by * kBlockSize + y)));
    block.valid.assign(block.values.size(), 1);
    return block;
  }

  RasterInfo info_;
  bool has_pyramid = false;
  double value_scale = 1.0;
  /// False: the read fails. `number` counts reads, from 1.
  std::function<bool(uint32_t reduction, uint32_t bx, uint32_t by, uint64_t number)> before;
  mutable std::atomic<uint64_t> reads{0};
};

inline void sleep_s(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

}  // namespace nepho::test
