#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "io/raster.h"

namespace nepho {

/// Blocks of rasters on disk, for the next start of the program: those that took long to make. One file each, in
/// cache_dir()/blocks, compressed without loss and with a checksum; written in the background, beside and renamed, so
/// that several processes may share the folder. What is damaged, cut off or of another version is made again. When the
/// files take more than the budget, those that were used longest ago go. A disk that refuses turns writing off with one
/// warning. Thread-safe.
class BlockStore {
 public:
  /// `folder` is made when the first block is written. `budget_bytes`: > 0.
  BlockStore(std::filesystem::path folder, uint64_t budget_bytes);
  /// Writes what waits to be written.
  ~BlockStore();
  BlockStore(const BlockStore&) = delete;
  BlockStore& operator=(const BlockStore&) = delete;

  /// The store of this machine's user, shared by all scenes of the program that are open together; null when the
  /// budget is 0 or there is no cache folder.
  static std::shared_ptr<BlockStore> of_user(uint64_t budget_bytes);

  /// A raster whose blocks are kept, for load() and save().
  struct Source {
    std::string identity;  ///< all that the numbers depend on; empty: nothing is kept
    std::string folder;    ///< follows from it
    uint32_t bands = 1;
    explicit operator bool() const { return !identity.empty(); }
  };
  /// By RasterInfo's path and fingerprint.
  static Source source_of(const RasterInfo& info);

  /// A block as it was saved, bit by bit.
  std::optional<RasterBlock> load(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by);
  /// Takes a block to be written later, by another thread while not too much waits.
  void save(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by,
            std::shared_ptr<const RasterBlock> block);
  /// Waits until all is written.
  void flush();

  struct Stats {
    uint64_t loaded = 0, saved = 0;  ///< blocks
    uint64_t damaged = 0;            ///< files that were not what they should be
    uint64_t removed = 0;            ///< files that had to make room
    bool writing = true;             ///< false: the disk refused
  };
  Stats stats() const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct Job {
    Source source;
    uint32_t reduction, bx, by;
    std::shared_ptr<const RasterBlock> block;
  };
  std::filesystem::path path_of(const Source& source, uint32_t reduction, uint32_t bx, uint32_t by) const;
  void serve();
  void write(const Job& job);
  void make_room();
  void turn_off(const std::string& why);

  const std::filesystem::path folder_;
  const uint64_t budget_bytes_;
  std::atomic<bool> writing_{true};
  std::atomic<uint64_t> loaded_{0}, saved_{0}, damaged_{0}, removed_{0};
  std::atomic<uint64_t> serial_{0};  // of temporary files
  std::mutex room_mutex_;
  uint64_t bytes_ = 0;  // of all files, as far as this process knows; guarded by room_mutex_
  bool counted_ = false;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  uint64_t waiting_bytes_ = 0;
  bool busy_ = false, stop_ = false;
  std::thread writer_;
};

}  // namespace nepho
