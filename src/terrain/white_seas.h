#pragma once
#include "terrain/block_cache.h"
#include "terrain/height_sampler.h"

namespace nepho {

/// Whether a picture is a map on white paper, or a mask, and no photograph: whether most of what it shows of the sea
/// within 45 degrees of the equator is as white as ice (ice_field()). Such a picture's white sea is no ice anywhere.
/// False where it shows no such sea, and for large rasters without a pyramid, which would have to be read whole.
bool has_white_seas(const BlockCache& picture, const HeightSampler& ground);

}  // namespace nepho
