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
    : builder_(builder), tiles_(std::move(budget)) {
  for (size_t i = 0; i < std::max<size_t>(threads, 1); ++i) threads_.emplace_back([this] { work(); });
}

TileLoader::~TileLoader() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    queue_.clear();
  }
  wanted_.notify_all();
  for (std::thread& t : threads_) t.join();
}

void TileLoader::request(const std::vector<TileId>& tiles) {
  {
    const std::lock_guard lock(mutex_);
    std::unordered_set<TileId> asked;
    std::deque<TileId> queue;
    for (const TileId& tile : tiles)
      if (!running_.contains(tile) && !tiles_.find(tile) && !given_up(tile) && asked.insert(tile).second)
        queue.push_back(tile);
    for (const TileId& tile : queue_) cancelled_ += !asked.contains(tile);
    queue_ = std::move(queue);
  }
  wanted_.notify_all();
}

void TileLoader::wait(double seconds) {
  std::unique_lock lock(mutex_);
  finished_.wait_for(lock, std::chrono::duration<double>(seconds),
                     [&] { return loaded_ != seen_ || (queue_.empty() && running_.empty()); });
  seen_ = loaded_;
}

TileLoader::Stats TileLoader::stats() const {
  const std::lock_guard lock(mutex_);
  return {loaded_, cancelled_, failed_, queue_.size() + running_.size()};
}

bool TileLoader::given_up(const TileId& tile) const {
  const auto found = failures_.find(tile);
  return found != failures_.end() && found->second >= kMostTries;
}

void TileLoader::fail(const TileId& tile, const char* why) {
  const std::lock_guard lock(mutex_);
  running_.erase(tile);
  if (++failures_[tile] < kMostTries) return;  // asked for again with the next frame
  if (failed_++ == 0) log_warning("terrain: a tile cannot be made ({}); its parent stays", why);
}

void TileLoader::work() {
  give_way();
  const OneCore one_core;
  for (;;) {
    TileId tile;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [&] { return stop_ || !queue_.empty(); });
      if (stop_) return;
      tile = queue_.front();
      queue_.pop_front();
      running_.insert(tile);
    }
    try {
      (void)tiles_.get(tile, [&]() -> HostCache<TileId, LoadedTile>::Made {
        auto made = std::make_shared<LoadedTile>(LoadedTile{builder_.make_meta(tile), builder_.make_data(tile)});
        const uint64_t bytes = made->bytes();
        return {std::move(made), bytes};
      });
    } catch (const std::exception& e) {
      fail(tile, e.what());
      finished_.notify_all();
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      running_.erase(tile);
      ++loaded_;
    }
    finished_.notify_all();
  }
}

}  // namespace nepho
