#include "rasters/gdal_raster.h"

#include <algorithm>
#include <utility>

#include "io/raster_grid.h"

namespace nepho {

namespace {
constexpr size_t kScratchPixels = size_t{1} << 20;
}

class GdalRaster::Lease {
 public:
  explicit Lease(const GdalRaster& raster) : raster_(raster), handle_(raster.take()) {}
  ~Lease() { raster_.give_back(std::move(handle_)); }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  DatasetHandle& operator*() const { return *handle_; }

 private:
  const GdalRaster& raster_;
  std::unique_ptr<DatasetHandle> handle_;
};

GdalRaster::GdalRaster(RasterInfo info, RasterLayout layout, DatasetChain first, Open open, size_t most_openings)
    : info_(std::move(info)), layout_(std::move(layout)), open_(std::move(open)), most_openings_(most_openings) {
  auto handle = std::make_unique<DatasetHandle>(std::move(first), layout_);
  for (uint32_t k = 0; k < reductions(); ++k) level_of_reduction_.push_back(handle->level_for(k).level);
  idle_.push_back(std::move(handle));
}

uint32_t GdalRaster::reductions() const { return reduction_count(info_.width, info_.height); }

uint32_t GdalRaster::pyramid_level(uint32_t reduction) const {
  return level_of_reduction_[std::min<size_t>(reduction, level_of_reduction_.size() - 1)];
}

std::unique_ptr<DatasetHandle> GdalRaster::take() const {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (!idle_.empty()) {
      std::unique_ptr<DatasetHandle> handle = std::move(idle_.back());
      idle_.pop_back();
      return handle;
    }
    if (openings_ >= most_openings_) {
      returned_.wait(lock);
      continue;
    }
    ++openings_;
    lock.unlock();
    try {
      return std::make_unique<DatasetHandle>(open_(), layout_);
    } catch (const Error&) {  // it did open once: go on with the openings that there are
      lock.lock();
      most_openings_ = --openings_;
    }
  }
}

void GdalRaster::give_back(std::unique_ptr<DatasetHandle> handle) const {
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(handle));
  }
  returned_.notify_one();
}

Result<RasterBlock> GdalRaster::read_block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  if (!block_window(info_, reduction, bx, by))
    return Result<RasterBlock>::failed(
        fmt::format("{}: has no block ({}, {}) at reduction {}", info_.path, bx, by, reduction));
  const Lease lease(*this);
  DatasetHandle& handle = *lease;
  const DatasetHandle::Level& level = handle.level_for(reduction);
  RasterInfo reduced = info_;
  reduced.width = level.width;
  reduced.height = level.height;
  const BlockWindow w = *block_window(reduced, reduction - level.level, bx, by);

  const GdalMessages messages;
  BlockAverager averager(w.src_width, w.src_height, info_.bands, w.factor);
  if (handle.is_empty(level, w.x0, w.y0, w.src_width, w.src_height)) return std::move(averager).finish();
  std::vector<float> values(size_t{w.src_width} * info_.bands);
  std::vector<uint8_t> valid(w.src_width);
  const auto strip = static_cast<uint32_t>(std::max<size_t>(1, kScratchPixels / w.src_width));
  for (uint32_t y = 0; y < w.src_height; y += strip) {
    const uint32_t rows = std::min(strip, w.src_height - y);
    if (!handle.read_raw(level, w.x0, w.y0 + y, w.src_width, rows) || messages.contains("Premature end of JPEG"))
      return Result<RasterBlock>::failed(
          fmt::format("{}: is cut off or damaged, its pixels cannot be read{}", info_.path, messages.in_brackets()));
    for (uint32_t row = 0; row < rows; ++row) {
      handle.deliver(row, w.src_width, rows, info_.bands, values, valid);
      averager.add_row(values, valid);
    }
  }
  return std::move(averager).finish();
}

}  // namespace nepho
