#pragma once
#include <atomic>
#include <cstdint>

namespace nepho {

/// While one lives on a thread, what BlockCache reads for that thread: a tile that is wanted at once is made as a
/// draft, without what would mean reading a great many pixels, and finished later. What was left out counts as no data
/// and is kept in no cache.
class TileReads {
 public:
  enum class Extent {
    everything,
    draft,   ///< what is cached, and what looks at few pixels
    nothing  ///< no data at all
  };
  /// `stop`, which may be null: once it is set, blocks are not made any more: Error(failure).
  explicit TileReads(Extent extent, const std::atomic<bool>* stop = nullptr);
  /// Of a thread that works for another one: as there, where what is left out counts too. Null: everything.
  explicit TileReads(TileReads* of);
  ~TileReads();
  TileReads(const TileReads&) = delete;
  TileReads& operator=(const TileReads&) = delete;

  Extent extent() const { return extent_; }
  uint64_t left_out() const { return left_out_; }  ///< blocks
  void leave_out() {
    ++left_out_;
    if (of_) of_->leave_out();
  }
  void check_stop() const;

  /// Of this thread; null: none.
  static TileReads* current();

 private:
  Extent extent_;
  const std::atomic<bool>* stop_;
  TileReads* of_ = nullptr;
  std::atomic<uint64_t> left_out_{0};
  TileReads* before_;
};

}  // namespace nepho
