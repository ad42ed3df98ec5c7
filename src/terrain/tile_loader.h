#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "terrain/host_cache.h"
#include "terrain/tile_builder.h"

namespace nepho {

/// A tile in the host's memory.
struct LoadedTile {
  TileMeta meta;
  TileData data;
  uint64_t bytes() const;
};

/// Makes tiles in background threads, in the order that is wanted now, and keeps finished ones as the host budget
/// allows.
class TileLoader {
 public:
  /// `builder` must outlive this object. The threads give way to the program's others.
  TileLoader(const TileBuilder& builder, size_t threads, std::shared_ptr<HostBudget> budget);
  /// Waits for the tiles that are being made; others are dropped.
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  /// What is wanted, the most urgent first. Takes the place of earlier wishes: those not repeated are cancelled, unless
  /// they have been begun. Tiles that are there or being made are skipped.
  void request(const std::vector<TileId>& tiles);
  /// A finished tile; null: not there.
  std::shared_ptr<const LoadedTile> find(const TileId& tile) const { return tiles_.find(tile); }
  /// Returns when a tile was finished since the last call, or none is wanted or being made, or after `seconds`.
  void wait(double seconds);

  struct Stats {
    uint64_t loaded = 0;     ///< tiles made since the start
    uint64_t cancelled = 0;  ///< wishes that were given up
    uint64_t failed = 0;     ///< tiles that could not be made, after another try; their parents stay
    size_t waiting = 0;      ///< tiles wanted or being made
  };
  Stats stats() const;

 private:
  void work();
  bool given_up(const TileId& tile) const;  // with mutex_ held
  void fail(const TileId& tile, const char* why);

  const TileBuilder& builder_;
  mutable std::mutex mutex_;
  std::condition_variable wanted_, finished_;
  std::deque<TileId> queue_;
  std::unordered_set<TileId> running_;
  HostCache<TileId, LoadedTile> tiles_;
  std::unordered_map<TileId, uint32_t> failures_;
  uint64_t loaded_ = 0, cancelled_ = 0, failed_ = 0, seen_ = 0;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace nepho
