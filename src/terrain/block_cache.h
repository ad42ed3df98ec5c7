#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// Blocks of one raster, kept in memory up to a budget. A raster that fits the budget as a whole is read at full size
/// only, and each of its blocks is reduced by itself, so that a coarse look at a place reads no more than the blocks
/// there. Others are read at the reductions that they offer. Reductions beyond those are averaged from the ones below:
/// a raster far smaller than a vertex spacing still contributes its mean. Thread-safe; a block is read once even when
/// two threads ask for it together. A block that cannot be read counts as "no data", with one warning per raster.
class BlockCache {
 public:
  struct Block {
    RasterBlock data;
    bool all_valid = false;
  };
  /// Changes a block after it was read from the raster (not those that are averaged from others).
  using Filter = std::function<void(RasterBlock& block, uint32_t reduction, uint32_t bx, uint32_t by)>;

  static constexpr uint64_t kBudgetBytes = 384u << 20;
  explicit BlockCache(std::shared_ptr<Raster> raster, uint64_t budget_bytes = kBudgetBytes, Filter filter = {});

  const RasterInfo& info() const { return info_; }
  /// Block (bx, by): pixels bx * side_at(reduction).. of the raster reduced by 2^reduction.
  std::shared_ptr<const Block> block(uint32_t reduction, uint32_t bx, uint32_t by) const;
  uint32_t width_at(uint32_t reduction) const;   ///< px
  uint32_t height_at(uint32_t reduction) const;  ///< px
  /// Pixels per side of a block; a power of two.
  uint32_t side_at(uint32_t reduction) const;
  /// Size of a source pixel in degrees; the larger of its two sides.
  double pixel_deg() const { return pixel_deg_; }
  /// Largest power-of-two reduction whose pixels are no larger than `spacing_deg`.
  uint32_t reduction_for(double spacing_deg) const;
  uint64_t blocks_read() const { return blocks_read_; }

 private:
  struct Entry {
    std::once_flag once;
    std::shared_ptr<const Block> block;
    uint64_t stamp = 0;
    uint64_t bytes = 0;
  };
  Block load(uint32_t reduction, uint32_t bx, uint32_t by) const;
  Block reduce_children(uint32_t reduction, uint32_t bx, uint32_t by) const;
  void trim() const;

  std::shared_ptr<Raster> raster_;
  RasterInfo info_;
  uint32_t own_reductions_ = 1;
  uint32_t last_reduction_ = 0;  // one pixel is left
  double pixel_deg_ = 1.0;
  uint64_t budget_bytes_;
  Filter filter_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<uint64_t, std::shared_ptr<Entry>> entries_;
  mutable uint64_t clock_ = 0, bytes_ = 0;
  mutable std::atomic<uint64_t> blocks_read_{0};
  mutable std::atomic<bool> warned_{false};
};

}  // namespace nepho
