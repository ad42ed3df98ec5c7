#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "io/raster.h"
#include "terrain/raster_caches.h"
#include "terrain/source_reader.h"
#include "terrain/tile_reads.h"

namespace nepho {

/// Blocks of one raster, kept in memory within the budget that all rasters of a scene share, and on disk where they
/// took long to make. Thread-safe; a block is read once even when two threads ask for it together.
///
/// A small raster is read at full size only, and each of its blocks is reduced by itself, so that a coarse look at a
/// place reads no more than the blocks there. Others are read at the reductions that they offer, as long as that reads
/// less than the finer blocks would. All other reductions are averaged from the ones below: a raster far smaller than a
/// vertex spacing still contributes its mean. None of this depends on the budget: a block has the same bits always.
///
/// A block that cannot be read (SourceReader) is made from finer blocks, as far as those can be read, or from a coarser
/// level of the source's own pyramid; what is still missing counts as no data.
///
/// A thread with TileReads gets less: see there.
class BlockCache {
 public:
  struct Block {
    RasterBlock data;
    bool all_valid = false;
    bool failed = false;  ///< part of it could not be read
  };
  /// Changes a block after it was read from the raster (not those that are averaged from others).
  using Filter = std::function<void(RasterBlock& block, uint32_t reduction, uint32_t bx, uint32_t by)>;

  explicit BlockCache(std::shared_ptr<Raster> raster, RasterCaches caches = {}, Filter filter = {});

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
  /// Whether looking at the whole raster means reading a great many of its pixels.
  bool whole_is_dear() const;

  uint64_t blocks_read() const { return raster_->stats().read; }
  SourceStats stats() const;
  const std::shared_ptr<HostBudget>& memory() const { return caches_.memory; }

 private:
  Block load(uint32_t reduction, uint32_t bx, uint32_t by) const;
  std::shared_ptr<const Block> make(uint32_t reduction, uint32_t bx, uint32_t by) const;
  template <typename F>
  std::shared_ptr<const Block> kept(uint32_t reduction, uint32_t bx, uint32_t by, F&& make_block) const;
  std::shared_ptr<const Block> partial_block(TileReads& reads, uint32_t reduction, uint32_t bx, uint32_t by) const;
  bool is_on_disk(uint32_t reduction) const;
  std::optional<RasterBlock> kept_on_disk(uint32_t reduction, uint32_t bx, uint32_t by) const;
  bool is_averaged(uint32_t reduction) const;
  Block average_children(uint32_t reduction, uint32_t bx, uint32_t by) const;
  Block replace_failed(uint32_t reduction, uint32_t bx, uint32_t by) const;
  Block empty_block(uint32_t reduction, uint32_t bx, uint32_t by) const;
  bool magnify_coarser(uint32_t reduction, uint32_t bx, uint32_t by, RasterBlock& to) const;

  std::shared_ptr<SourceReader> raster_;
  RasterInfo info_;
  RasterCaches caches_;
  BlockStore::Source source_;
  uint32_t own_reductions_ = 1;
  uint32_t last_reduction_ = 0;  // one pixel is left
  double pixel_deg_ = 1.0;
  Filter filter_;
  HostCache<uint64_t, Block> blocks_;
  mutable std::atomic<uint64_t> averaged_{0}, from_disk_{0};
};

}  // namespace nepho
