#pragma once
#include <span>
#include <vector>

#include "terrain/block_cache.h"

namespace nepho {

/// Bilinear values of one raster; weight is the bilinear share of valid pixels times the raster's opacity, values are
/// of the valid ones alone.
/// Returns false when no place has any data.
bool sample_layer(const BlockCache& raster, std::span<const double> lat_deg, std::span<const double> lon_deg,
                  uint32_t reduction, std::vector<double>& value, std::vector<float>& weight);

/// Whether any place of a grid lies on a raster.
bool overlaps_grid(const LonLatBounds& bounds, std::span<const double> lat_deg, std::span<const double> lon_deg);

}  // namespace nepho
