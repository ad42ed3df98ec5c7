#pragma once
#include <memory>

#include "io/raster.h"
#include "terrain/raster_caches.h"

namespace nepho {

/// A raster read through a BlockCache, for those that know rasters only: its blocks come from memory and disk, and what
/// cannot be read is no data instead of a failure.
std::shared_ptr<Raster> make_cached_raster(std::shared_ptr<Raster> raster, const RasterCaches& caches);

}  // namespace nepho
