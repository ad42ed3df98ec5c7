#include "terrain/block_cache.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"

namespace nepho {

namespace {
constexpr uint32_t kSide = Raster::kBlockSize;

uint32_t reduced(uint32_t size, uint32_t reduction) {
  const uint64_t step = uint64_t{1} << reduction;
  return static_cast<uint32_t>((size + step - 1) / step);
}
}  // namespace

BlockCache::BlockCache(std::shared_ptr<Raster> raster, uint64_t budget_bytes, Filter filter, bool reduces)
    : raster_(std::move(raster)), info_(raster_->info()), budget_bytes_(budget_bytes), filter_(std::move(filter)) {
  NEPHO_ASSERT(info_.width > 0 && info_.height > 0);
  own_reductions_ = std::max(1u, raster_->reductions());
  const uint64_t whole_bytes = uint64_t{info_.width} * info_.height * (info_.bands * sizeof(float) + 1);
  if (reduces && whole_bytes <= budget_bytes_ / 2) own_reductions_ = 1;
  while (reduced(std::max(info_.width, info_.height), last_reduction_) > 1) ++last_reduction_;
  pixel_deg_ = std::max((info_.bounds.east_deg - info_.bounds.west_deg) / info_.width,
                        (info_.bounds.north_deg - info_.bounds.south_deg) / info_.height);
}

uint32_t BlockCache::width_at(uint32_t reduction) const { return reduced(info_.width, reduction); }
uint32_t BlockCache::height_at(uint32_t reduction) const { return reduced(info_.height, reduction); }

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
  to.width = std::min(kSide, width_at(reduction) - bx * kSide);
  to.height = std::min(kSide, height_at(reduction) - by * kSide);
  to.values.assign(size_t{to.width} * to.height * bands, 0.0f);
  to.valid.assign(size_t{to.width} * to.height, 0);
  const uint32_t blocks_x = (width_at(reduction - 1) + kSide - 1) / kSide;
  const uint32_t blocks_y = (height_at(reduction - 1) + kSide - 1) / kSide;
  for (uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
    const uint32_t cx = 2 * bx + (quadrant & 1), cy = 2 * by + (quadrant >> 1);
    if (cx >= blocks_x || cy >= blocks_y) continue;
    const auto child = block(reduction - 1, cx, cy);
    const RasterBlock& from = child->data;
    const uint32_t x0 = (quadrant & 1) * kSide / 2, y0 = (quadrant >> 1) * kSide / 2;
    for (uint32_t y = 0; y < (from.height + 1) / 2; ++y)
      for (uint32_t x = 0; x < (from.width + 1) / 2; ++x) {
        size_t taps[4];
        uint32_t count = 0;
        for (uint32_t j = 2 * y; j < std::min(2 * y + 2, from.height); ++j)
          for (uint32_t i = 2 * x; i < std::min(2 * x + 2, from.width); ++i)
            if (from.valid[size_t{j} * from.width + i]) taps[count++] = size_t{j} * from.width + i;
        if (count == 0) continue;
        const size_t at = size_t{y0 + y} * to.width + x0 + x;
        to.valid[at] = 1;
        for (uint32_t b = 0; b < bands; ++b) {
          double sum = 0.0;
          for (uint32_t t = 0; t < count; ++t) sum += static_cast<double>(from.values[taps[t] * bands + b]);
          to.values[at * bands + b] = static_cast<float>(sum / count);
        }
      }
  }
  return out;
}

}  // namespace nepho
