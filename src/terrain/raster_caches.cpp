#include "terrain/raster_caches.h"

#include "scene/scene.h"

namespace nepho {

RasterCaches make_raster_caches(const TerrainParams& params) {
  constexpr uint64_t kMiB = 1u << 20;
  return {.memory = std::make_shared<HostBudget>(params.host_budget_mb * kMiB),
          .disk = BlockStore::of_user(params.disk_cache_mb * kMiB),
          .timeout_s = params.source_timeout_s};
}

}  // namespace nepho
