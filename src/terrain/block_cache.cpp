#include "terrain/block_cache.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/seconds_since.h"

namespace nepho {

namespace {

constexpr uint32_t kSide = Raster::kBlockSize;
constexpr uint32_t kSideBits = 8;
static_assert(kSide == 1u << kSideBits);

constexpr uint64_t kOwnBudgetBytes = 384u << 20;
/// A raster of at most this size, uncompressed, is read at full size only. Not a matter of the budget: the bits of a
/// reduction must not depend on that.
constexpr uint64_t kSmallBytes = 192u << 20;
/// A block at this reduction stands for 2048 x 2048 pixels of the source: enough for a read to be worth its while.
constexpr uint32_t kDirectReductions = 3;
/// Blocks that took longer than this go to the disk.
constexpr double kDear_s = 0.002;
/// Reading more pixels than this to learn a raster's range is too much.
constexpr uint64_t kDearPixels = uint64_t{1} << 24;

constexpr uint64_t kOwnBit = uint64_t{1} << 63;

uint32_t reduced(uint32_t size, uint32_t reduction) {
  const uint64_t step = uint64_t{1} << reduction;
  return static_cast<uint32_t>((size + step - 1) / step);
}

uint64_t key_of(uint32_t reduction, uint32_t bx, uint32_t by) {
  return (uint64_t{reduction} << 56) | (uint64_t{by} << 28) | bx;
}

uint64_t bytes_of(const RasterBlock& block) { return block.values.size() * sizeof(float) + block.valid.size(); }

RasterCaches completed(RasterCaches caches) {
  if (!caches.memory) caches.memory = std::make_shared<HostBudget>(kOwnBudgetBytes);
  return caches;
}

}  // namespace

BlockCache::BlockCache(std::shared_ptr<Raster> raster, RasterCaches caches, Filter filter)
    : raster_(SourceReader::of(std::move(raster), caches.timeout_s)),
      info_(raster_->info()),
      caches_(completed(std::move(caches))),
      source_(caches_.disk ? BlockStore::source_of(info_) : BlockStore::Source{}),
      filter_(std::move(filter)),
      blocks_(caches_.memory) {
  NEPHO_ASSERT(info_.width > 0 && info_.height > 0);
  own_reductions_ = std::max(1u, raster_->reductions());
  const uint64_t whole_bytes = uint64_t{info_.width} * info_.height * (info_.bands * sizeof(float) + 1);
  if (whole_bytes <= kSmallBytes) own_reductions_ = 1;
  while (reduced(std::max(info_.width, info_.height), last_reduction_) > 1) ++last_reduction_;
  pixel_deg_ = std::max((info_.bounds.east_deg - info_.bounds.west_deg) / info_.width,
                        (info_.bounds.north_deg - info_.bounds.south_deg) / info_.height);
}

uint32_t BlockCache::width_at(uint32_t reduction) const { return reduced(info_.width, reduction); }
uint32_t BlockCache::height_at(uint32_t reduction) const { return reduced(info_.height, reduction); }

uint32_t BlockCache::side_at(uint32_t reduction) const {
  // Reduced by themselves, the blocks of a small raster shrink to one pixel; from there on they are collected again.
  return own_reductions_ == 1 && reduction <= kSideBits ? kSide >> reduction : kSide;
}

uint32_t BlockCache::reduction_for(double spacing_deg) const {
  // The margin keeps rasters on the tiles' own grid (pixel = spacing) from falling to the finer side by rounding.
  uint32_t k = 0;
  while (k < last_reduction_ && std::ldexp(pixel_deg_, static_cast<int>(k) + 1) <= spacing_deg * (1.0 + 1e-9)) ++k;
  return k;
}

bool BlockCache::is_averaged(uint32_t reduction) const {
  if (reduction == 0) return false;
  if (reduction >= own_reductions_) return true;
  // Without a level of its own a read would look at all the pixels below once more.
  return reduction > kDirectReductions && raster_->pyramid_level(reduction) == raster_->pyramid_level(reduction - 1);
}

bool BlockCache::whole_is_dear() const {
  uint32_t level = 0;
  for (uint32_t k = 0; k < own_reductions_; ++k) level = std::max(level, raster_->pyramid_level(k));
  return uint64_t{width_at(level)} * height_at(level) > kDearPixels;
}

std::shared_ptr<const BlockCache::Block> BlockCache::block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  if (TileReads* const reads = TileReads::current()) {
    reads->check_stop();
    if (reads->extent() != TileReads::Extent::everything) return partial_block(*reads, reduction, bx, by);
  }
  return kept(reduction, bx, by, [&] { return make(reduction, bx, by); });
}

template <typename F>
std::shared_ptr<const BlockCache::Block> BlockCache::kept(uint32_t reduction, uint32_t bx, uint32_t by,
                                                          F&& make_block) const {
  return blocks_.get(key_of(reduction, bx, by), [&]() -> HostCache<uint64_t, Block>::Made {
    std::shared_ptr<const Block> block = make_block();
    const uint64_t bytes = bytes_of(block->data) + sizeof(Block);
    return {std::move(block), bytes};
  });
}

std::shared_ptr<const BlockCache::Block> BlockCache::make(uint32_t reduction, uint32_t bx, uint32_t by) const {
  auto block = std::make_shared<Block>(load(reduction, bx, by));
  const std::vector<uint8_t>& valid = block->data.valid;
  block->all_valid = std::all_of(valid.begin(), valid.end(), [](uint8_t v) { return v != 0; });
  return block;
}

std::shared_ptr<const BlockCache::Block> BlockCache::partial_block(TileReads& reads, uint32_t reduction, uint32_t bx,
                                                                   uint32_t by) const {
  if (reads.extent() == TileReads::Extent::nothing) {
    reads.leave_out();
    return std::make_shared<Block>(empty_block(reduction, bx, by));
  }
  if (auto there = blocks_.find(key_of(reduction, bx, by))) return there;
  const bool dear = reduction > kDirectReductions && is_averaged(reduction) && whole_is_dear();
  if (dear && !kept_on_disk(reduction, bx, by)) {
    reads.leave_out();
    return std::make_shared<Block>(empty_block(reduction, bx, by));
  }
  if (!filter_) return kept(reduction, bx, by, [&] { return make(reduction, bx, by); });
  // A filter may look at other rasters, of which something may be left out; and who makes the same block with
  // everything may take long.
  const uint64_t before = reads.left_out();
  const std::shared_ptr<const Block> block = make(reduction, bx, by);
  return reads.left_out() == before ? kept(reduction, bx, by, [&] { return block; }) : block;
}

/// What a filter made depends on more than this raster: only what it starts from is kept.
bool BlockCache::is_on_disk(uint32_t reduction) const { return source_ && !(is_averaged(reduction) && filter_); }

std::optional<RasterBlock> BlockCache::kept_on_disk(uint32_t reduction, uint32_t bx, uint32_t by) const {
  if (!is_on_disk(reduction)) return std::nullopt;
  std::optional<RasterBlock> found = caches_.disk->load(source_, reduction, bx, by);
  if (found && found->width == std::min(side_at(reduction), width_at(reduction) - bx * side_at(reduction)) &&
      found->height == std::min(side_at(reduction), height_at(reduction) - by * side_at(reduction)))
    return found;
  return std::nullopt;
}

BlockCache::Block BlockCache::load(uint32_t reduction, uint32_t bx, uint32_t by) const {
  const bool averaged = is_averaged(reduction), on_disk = is_on_disk(reduction);
  Block out;
  bool kept = false;
  if (std::optional<RasterBlock> found = kept_on_disk(reduction, bx, by)) {
    out.data = std::move(*found);
    kept = true;
    ++from_disk_;
  }
  const auto start = std::chrono::steady_clock::now();
  if (!kept && averaged) {
    out = raster_->may_be_read() ? average_children(reduction, bx, by) : empty_block(reduction, bx, by);
    ++averaged_;
  } else if (!kept) {
    Result<RasterBlock> own = raster_->read_block(reduction, bx, by);
    if (!own) return replace_failed(reduction, bx, by);
    out.data = std::move(*own);
  }
  if (on_disk && !kept && !out.failed && seconds_since(start) > kDear_s)
    caches_.disk->save(source_, reduction, bx, by, std::make_shared<const RasterBlock>(out.data));
  if (!averaged && filter_) filter_(out.data, reduction, bx, by);
  return out;
}

BlockCache::Block BlockCache::empty_block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  Block out;
  const uint32_t side = side_at(reduction);
  out.data.width = std::min(side, width_at(reduction) - bx * side);
  out.data.height = std::min(side, height_at(reduction) - by * side);
  const size_t pixels = size_t{out.data.width} * out.data.height;
  out.data.values.assign(pixels * info_.bands, 0.0f);
  out.data.valid.assign(pixels, 0);
  out.failed = true;
  return out;
}

BlockCache::Block BlockCache::replace_failed(uint32_t reduction, uint32_t bx, uint32_t by) const {
  Block out = empty_block(reduction, bx, by);
  if (!raster_->may_be_read()) return out;
  if (reduction > 0) {
    out = average_children(reduction, bx, by);  // they have had their filter
  } else if (magnify_coarser(reduction, bx, by, out.data) && filter_) {
    filter_(out.data, reduction, bx, by);
  }
  out.failed = true;
  return out;
}

bool BlockCache::magnify_coarser(uint32_t reduction, uint32_t bx, uint32_t by, RasterBlock& to) const {
  for (uint32_t up = 1; reduction + up < own_reductions_ && raster_->may_be_read(); ++up) {
    // A coarser level helps where it was stored apart: else it is made of the very pixels that are missing.
    const uint32_t k = reduction + up;
    if (is_averaged(k) || raster_->pyramid_level(k) <= raster_->pyramid_level(k - 1)) continue;
    const auto coarse = blocks_.get(key_of(k, bx >> up, by >> up) | kOwnBit, [&] {
      auto made = std::make_shared<Block>();
      if (Result<RasterBlock> own = raster_->read_block(k, bx >> up, by >> up)) made->data = std::move(*own);
      const uint64_t bytes = bytes_of(made->data) + sizeof(Block);
      return HostCache<uint64_t, Block>::Made{std::move(made), bytes};
    });
    const RasterBlock& from = coarse->data;
    if (from.valid.empty()) continue;
    const uint32_t x0 = ((bx >> up) * kSide) << up, y0 = ((by >> up) * kSide) << up;
    for (uint32_t y = 0; y < to.height; ++y)
      for (uint32_t x = 0; x < to.width; ++x) {
        const size_t source = size_t{(by * kSide + y - y0) >> up} * from.width + ((bx * kSide + x - x0) >> up);
        const size_t target = size_t{y} * to.width + x;
        to.valid[target] = from.valid[source];
        for (uint32_t b = 0; b < info_.bands; ++b)
          to.values[target * info_.bands + b] = from.values[source * info_.bands + b];
      }
    return true;
  }
  return false;
}

BlockCache::Block BlockCache::average_children(uint32_t reduction, uint32_t bx, uint32_t by) const {
  Block out = empty_block(reduction, bx, by);
  out.failed = false;
  const uint32_t bands = info_.bands;
  RasterBlock& to = out.data;
  const uint32_t side = side_at(reduction), side_below = side_at(reduction - 1);
  // Pixels below, and the blocks that hold them: one for a block reduced by itself.
  const uint32_t x0 = 2 * bx * side, y0 = 2 * by * side;
  const uint32_t x1 = std::min(x0 + 2 * side, width_at(reduction - 1)),
                 y1 = std::min(y0 + 2 * side, height_at(reduction - 1));
  std::vector<double> sums(to.values.size());
  std::vector<uint32_t> counts(to.valid.size());
  for (uint32_t cy = y0 / side_below; cy * side_below < y1; ++cy)
    for (uint32_t cx = x0 / side_below; cx * side_below < x1; ++cx) {
      const auto child = block(reduction - 1, cx, cy);
      const RasterBlock& from = child->data;
      out.failed = out.failed || child->failed;
      for (uint32_t y = 0; y < from.height; ++y)
        for (uint32_t x = 0; x < from.width; ++x) {
          const uint32_t px = cx * side_below + x, py = cy * side_below + y;
          const size_t source = size_t{y} * from.width + x;
          if (!from.valid[source] || px < x0 || py < y0 || px >= x1 || py >= y1) continue;
          const size_t target = size_t{(py - y0) / 2} * to.width + (px - x0) / 2;
          ++counts[target];
          for (uint32_t b = 0; b < bands; ++b)
            sums[target * bands + b] += static_cast<double>(from.values[source * bands + b]);
        }
    }
  for (size_t p = 0; p < counts.size(); ++p) {
    if (counts[p] == 0) continue;
    to.valid[p] = 1;
    for (uint32_t b = 0; b < bands; ++b) to.values[p * bands + b] = static_cast<float>(sums[p * bands + b] / counts[p]);
  }
  return out;
}

SourceStats BlockCache::stats() const {
  SourceStats s = raster_->stats();
  s.averaged = averaged_;
  s.from_disk = from_disk_;
  return s;
}

}  // namespace nepho
