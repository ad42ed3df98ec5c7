#pragma once
#include <atomic>
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
#include "terrain/tile_reads.h"

namespace nepho {

/// A tile in the host's memory.
struct LoadedTile {
  TileMeta meta;
  TileData data;
  bool draft = false;  ///< made without what would have taken long to read (TileReads)
  uint64_t bytes() const;
};

/// Makes tiles in background threads, in the order that is wanted now, and keeps them as the host budget allows. Where
/// data take long to read a tile is a draft at first; drafts are finished by a thread of their own.
class TileLoader {
 public:
  /// `builder` must outlive this object. The threads give way to the program's others.
  TileLoader(const TileBuilder& builder, size_t threads, std::shared_ptr<HostBudget> budget);
  /// Waits for the blocks that are being read; the tiles are dropped.
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  /// What is wanted, the most urgent first. Takes the place of earlier wishes: those not repeated are cancelled, unless
  /// they have been begun. Tiles that are there or being made are skipped.
  void request(const std::vector<TileId>& tiles);
  /// The same for drafts that are to be finished.
  void finish(const std::vector<TileId>& drafts);
  /// A tile as far as it is made; null: not there.
  std::shared_ptr<const LoadedTile> find(const TileId& tile) const {
    auto finished = tiles_.find(tile);
    return finished ? finished : drafts_.find(tile);
  }
  /// Returns when a tile was finished since the last call, or none is wanted or being made, or after `seconds`.
  void wait(double seconds);

  struct Stats {
    uint64_t loaded = 0;     ///< tiles made since the start, drafts too
    uint64_t cancelled = 0;  ///< wishes that were given up
    uint64_t failed = 0;     ///< tiles that could not be made, after another try; their parents stay
    size_t waiting = 0;      ///< tiles wanted or being made
  };
  Stats stats() const;

 private:
  struct Queue {
    std::deque<TileId> tiles;
    std::unordered_set<TileId> running;
  };
  void work(Queue& queue, TileReads::Extent extent);
  void replace(Queue& queue, const std::vector<TileId>& tiles, bool drafts_do);
  LoadedTile make(const TileId& tile, TileReads::Extent extent) const;
  bool given_up(const TileId& tile) const;  // with mutex_ held
  void fail(Queue& queue, const TileId& tile, const char* why);

  const TileBuilder& builder_;
  mutable std::mutex mutex_;
  std::condition_variable wanted_, finished_;
  Queue wishes_, unfinished_;
  HostCache<TileId, LoadedTile> tiles_, drafts_;
  std::unordered_map<TileId, uint32_t> failures_;
  uint64_t loaded_ = 0, cancelled_ = 0, failed_ = 0, seen_ = 0;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace nepho
