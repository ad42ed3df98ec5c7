#include "terrain/block_cache.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"

namespace nepho {

namespace {
constexpr uint32_t kSide = Raster::kBlockSize;
constexpr uint32_t kSideBits = 8;
static_assert(kSide == 1u << kSideBits);

uint32_t reduced(uint32_t size, uint32_t reduction) {
  const uint64_t step = uint64_t{1} << reduction;
  return static_cast<uint32_t>((size + step - 1) / step);
}
}  // namespace

BlockCache::BlockCache(std::shared_ptr<Raster> raster, uint64_t budget_bytes, Filter filter)
    : raster_(std::move(raster)), info_(raster_->info()), budget_bytes_(budget_bytes), filter_(std::move(filter)) {
  NEPHO_ASSERT(info_.width > 0 && info_.height > 0);
  own_reductions_ = std::max(1u, raster_->reductions());
  const uint64_t whole_bytes = uint64_t{info_.width} * info_.height * (info_.bands * sizeof(float) + 1);
  if (whole_bytes <= budget_bytes_ / 2) own_reductions_ = 1;
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

std::shared_ptr<const BlockCache::Block> BlockCache::block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  const uint64_t key = (uint64_t{reduction} << 56) | (uint64_t{by} << 28) | bx;
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    auto& slot = entries_[key];
    if (!slot) slot = std::make_shared<Entry>();
    slot->stamp = ++clock_;
    entry = slot;
  }
  std::call_once(entry->once, [&] {
    auto loaded = std::make_shared<const Block>(load(reduction, bx, by));
    const uint64_t bytes = loaded->data.values.size() * sizeof(float) + loaded->data.valid.size();
    const std::lock_guard lock(mutex_);
    entry->block = std::move(loaded);
    entry->bytes = bytes;
    bytes_ += bytes;
    if (bytes_ > budget_bytes_) trim();
  });
  return entry->block;
}

void BlockCache::trim() const {
  // Down to three quarters, oldest first; blocks in use stay alive through their shared_ptr.
  std::vector<std::pair<uint64_t, uint64_t>> ages;
  for (const auto& [key, entry] : entries_)
    if (entry->bytes > 0) ages.emplace_back(entry->stamp, key);
  std::sort(ages.begin(), ages.end());
  for (const auto& [stamp, key] : ages) {
    if (bytes_ <= budget_bytes_ / 4 * 3) break;
    const auto found = entries_.find(key);
    bytes_ -= found->second->bytes;
    entries_.erase(found);
  }
}

BlockCache::Block BlockCache::load(uint32_t reduction, uint32_t bx, uint32_t by) const {
  Block out;
  if (reduction >= own_reductions_) {
    out = reduce_children(reduction, bx, by);
  } else {
    Result<RasterBlock> read = raster_->read_block(reduction, bx, by);
    ++blocks_read_;
    if (read) {
      out.data = std::move(*read);
      if (filter_) filter_(out.data, reduction, bx, by);
    } else {
      if (!warned_.exchange(true)) log_warning("{}; such parts count as no data", read.reason());
      out.data.width = std::min(kSide, width_at(reduction) - bx * kSide);
      out.data.height = std::min(kSide, height_at(reduction) - by * kSide);
      const size_t pixels = size_t{out.data.width} * out.data.height;
      out.data.values.assign(pixels * info_.bands, 0.0f);
      out.data.valid.assign(pixels, 0);
    }
  }
  out.all_valid = std::all_of(out.data.valid.begin(), out.data.valid.end(), [](uint8_t v) { return v != 0; });
  return out;
}

BlockCache::Block BlockCache::reduce_children(uint32_t reduction, uint32_t bx, uint32_t by) const {
  Block out;
  const uint32_t bands = info_.bands;
  RasterBlock& to = out.data;
  const uint32_t side = side_at(reduction), side_below = side_at(reduction - 1);
  to.width = std::min(side, width_at(reduction) - bx * side);
  to.height = std::min(side, height_at(reduction) - by * side);
  to.values.assign(size_t{to.width} * to.height * bands, 0.0f);
  to.valid.assign(size_t{to.width} * to.height, 0);
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

}  // namespace nepho
