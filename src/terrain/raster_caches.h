#pragma once
#include <memory>
#include <string>
#include <vector>

#include "terrain/block_store.h"
#include "terrain/host_cache.h"

namespace nepho {

struct TerrainParams;

/// What the block caches of a scene share.
struct RasterCaches {
  std::shared_ptr<HostBudget> memory = {};  ///< null: a budget of its own for each cache
  std::shared_ptr<BlockStore> disk = {};    ///< null: nothing is kept on disk
  double timeout_s = 0.0;  ///< a source that does not answer has failed after this time, s; 0: waits for ever
};

/// By host_budget_mb, disk_cache_mb and source_timeout_s.
RasterCaches make_raster_caches(const TerrainParams& params);

/// What became of the blocks of one raster.
struct SourceStats {
  std::string path;
  uint64_t read = 0;       ///< blocks read from the raster itself
  uint64_t averaged = 0;   ///< made from finer ones
  uint64_t from_disk = 0;  ///< read from the disk cache
  uint64_t retried = 0;    ///< reads that failed and were tried again
  uint64_t failed = 0;     ///< blocks that could not be read, and show what lies below
  bool given_up = false;   ///< it does not answer, or nothing but errors: not read any more
  std::string failure;     ///< the first one, as it was warned of; empty: none
};

}  // namespace nepho
