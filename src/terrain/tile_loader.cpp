#include "terrain/tile_loader.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "base/give_way.h"
#include "base/log.h"
#include "base/parallel.h"

namespace nepho {

namespace {

constexpr uint32_t kMostTries = 2;

}  // namespace

uint64_t LoadedTile::bytes() const {
  uint64_t sum = sizeof(LoadedTile) + data.vertices.size() * sizeof(TileVertex);
  for (const auto& mip : data.imagery) sum += mip.size();
  for (const auto& mip : data.slopes) sum += mip.size() * sizeof(uint32_t);
  return sum;
}

TileLoader::TileLoader(const TileBuilder& builder, size_t threads, std::shared_ptr<HostBudget> budget)
    : builder_(builder), tiles_(budget), drafts_(budget) {
  for (size_t i = 0; i < std::max<size_t>(threads, 1); ++i)
    threads_.emplace_back([this] { work(wishes_, TileReads::Extent::draft); });
  threads_.emplace_back([this] { work(unfinished_, TileReads::Extent::everything); });
}

TileLoader::~TileLoader() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wanted_.notify_all();
  for (std::thread& t : threads_) t.join();
}

void TileLoader::request(const std::vector<TileId>& tiles) {
  {
    const std::lock_guard lock(mutex_);
    replace(wishes_, tiles, true);
  }
  wanted_.notify_all();
}

void TileLoader::finish(const std::vector<TileId>& drafts) {
  {
    const std::lock_guard lock(mutex_);
    replace(unfinished_, drafts, false);
  }
  wanted_.notify_all();
}

void TileLoader::replace(Queue& queue, const std::vector<TileId>& tiles, bool drafts_do) {
  std::unordered_set<TileId> asked;
  std::deque<TileId> wanted;
  for (const TileId& tile : tiles)
    if (!queue.running.contains(tile) && !tiles_.find(tile) && !(drafts_do && drafts_.find(tile)) && !given_up(tile) &&
        asked.insert(tile).second)
      wanted.push_back(tile);
  for (const TileId& tile : queue.tiles) cancelled_ += !asked.contains(tile);
  queue.tiles = std::move(wanted);
}

void TileLoader::wait(double seconds) {
  std::unique_lock lock(mutex_);
  finished_.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    return loaded_ != seen_ || (wishes_.tiles.empty() && wishes_.running.empty() && unfinished_.tiles.empty() &&
                                unfinished_.running.empty());
  });
  seen_ = loaded_;
}

TileLoader::Stats TileLoader::stats() const {
  const std::lock_guard lock(mutex_);
  return {loaded_, cancelled_, failed_,
          wishes_.tiles.size() + wishes_.running.size() + unfinished_.tiles.size() + unfinished_.running.size()};
}

bool TileLoader::given_up(const TileId& tile) const {
  const auto found = failures_.find(tile);
  return found != failures_.end() && found->second >= kMostTries;
}

void TileLoader::fail(Queue& queue, const TileId& tile, const char* why) {
  const std::lock_guard lock(mutex_);
  queue.running.erase(tile);
  if (stop_ || ++failures_[tile] < kMostTries) return;  // asked for again with the next frame
  if (failed_++ == 0) log_warning("terrain: a tile cannot be made ({}); its parent stays", why);
}

LoadedTile TileLoader::make(const TileId& tile, TileReads::Extent extent) const {
  const TileReads reads(extent, &stop_);
  LoadedTile made{builder_.make_meta(tile), builder_.make_data(tile)};
  made.draft = reads.left_out() > 0;
  return made;
}

void TileLoader::work(Queue& queue, TileReads::Extent extent) {
  give_way();
  const OneCore one_core;
  for (;;) {
    TileId tile;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [&] { return stop_ || !queue.tiles.empty(); });
      if (stop_) return;
      tile = queue.tiles.front();
      queue.tiles.pop_front();
      queue.running.insert(tile);
    }
    try {
      const auto made = std::make_shared<const LoadedTile>(make(tile, extent));
      (void)(made->draft ? drafts_ : tiles_).get(tile, [&]() -> HostCache<TileId, LoadedTile>::Made {
        return {made, made->bytes()};
      });
    } catch (const std::exception& e) {
      fail(queue, tile, e.what());
      finished_.notify_all();
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      queue.running.erase(tile);
      ++loaded_;
    }
    finished_.notify_all();
  }
}

}  // namespace nepho
