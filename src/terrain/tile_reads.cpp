#include "terrain/tile_reads.h"

#include "base/error.h"

namespace nepho {

namespace {
thread_local TileReads* of_this_thread = nullptr;
}

TileReads::TileReads(Extent extent, const std::atomic<bool>* stop)
    : extent_(extent), stop_(stop), before_(of_this_thread) {
  of_this_thread = this;
}

TileReads::TileReads(TileReads* of) : TileReads(of ? of->extent_ : Extent::everything, of ? of->stop_ : nullptr) {
  of_ = of;
}

TileReads::~TileReads() { of_this_thread = before_; }

TileReads* TileReads::current() { return of_this_thread; }

void TileReads::check_stop() const {
  if (stop_ && *stop_) throw fail(ErrorKind::failure, "a tile is not needed any more");
}

}  // namespace nepho
