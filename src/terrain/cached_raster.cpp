#include "terrain/cached_raster.h"

#include <algorithm>

#include "io/raster_grid.h"
#include "terrain/block_cache.h"

namespace nepho {

namespace {

class CachedRaster final : public Raster {
 public:
  CachedRaster(std::shared_ptr<Raster> raster, const RasterCaches& caches)
      : raster_(std::move(raster)), blocks_(raster_, caches) {}
  const RasterInfo& info() const override { return raster_->info(); }
  uint32_t reductions() const override { return raster_->reductions(); }
  uint32_t pyramid_level(uint32_t reduction) const override { return raster_->pyramid_level(reduction); }

  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override {
    if (!block_window(info(), reduction, bx, by))
      return Result<RasterBlock>::failed(
          fmt::format("{}: has no block ({}, {}) at reduction {}", info().path, bx, by, reduction));
    // The cache's own blocks may be smaller.
    const uint32_t side = blocks_.side_at(reduction), bands = info().bands;
    const uint32_t x0 = bx * kBlockSize, y0 = by * kBlockSize;
    RasterBlock out{.width = std::min(kBlockSize, blocks_.width_at(reduction) - x0),
                    .height = std::min(kBlockSize, blocks_.height_at(reduction) - y0),
                    .values = {},
                    .valid = {}};
    out.valid.resize(size_t{out.width} * out.height);
    out.values.resize(out.valid.size() * bands);
    for (uint32_t y = 0; y < out.height; y += side)
      for (uint32_t x = 0; x < out.width; x += side) {
        const auto block = blocks_.block(reduction, (x0 + x) / side, (y0 + y) / side);
        const RasterBlock& from = block->data;
        for (uint32_t row = 0; row < from.height; ++row) {
          const auto source = static_cast<std::ptrdiff_t>(size_t{row} * from.width);
          const auto target = static_cast<std::ptrdiff_t>(size_t{y + row} * out.width + x);
          std::copy_n(from.valid.begin() + source, from.width, out.valid.begin() + target);
          std::copy_n(from.values.begin() + source * bands, size_t{from.width} * bands,
                      out.values.begin() + target * bands);
        }
      }
    return out;
  }

 private:
  std::shared_ptr<Raster> raster_;
  BlockCache blocks_;
};

}  // namespace

std::shared_ptr<Raster> make_cached_raster(std::shared_ptr<Raster> raster, const RasterCaches& caches) {
  return std::make_shared<CachedRaster>(std::move(raster), caches);
}

}  // namespace nepho
