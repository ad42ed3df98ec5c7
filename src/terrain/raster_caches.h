#pragma once
#include <memory>

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

}  // namespace nepho
