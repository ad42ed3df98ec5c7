#pragma once
#include <memory>

#include "gpu/device.h"
#include "io/raster.h"
#include "terrain/raster_caches.h"

namespace nepho {

/// City lights as a map of the world (rgba8_srgb, equirectangular, with mips); one black texel without a raster.
gpu::Image make_night_lights(gpu::Device& device, const std::shared_ptr<Raster>& raster, const RasterCaches& caches);

}  // namespace nepho
