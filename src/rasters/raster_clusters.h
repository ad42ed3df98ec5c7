#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace nepho {

/// Extent and pixel size of a raster in the units of its CRS.
struct ClusterTile {
  double west = 0, south = 0, east = 0, north = 0;
  double dx = 1, dy = 1;  ///< > 0
};

/// Which tiles to put together: those that touch (to a pixel and a half) and differ in pixel size by less than a factor
/// of four. The empty middle between tiles far apart belongs to none. More than kMostClusters are joined by their
/// places. `around`: 360 where x are degrees of longitude, so that tiles touch across the antimeridian; 0: never.
/// Returns indices of `tiles`, each once, ascending in every cluster.
std::vector<std::vector<size_t>> cluster_tiles(std::span<const ClusterTile> tiles, double around);

inline constexpr size_t kMostClusters = 64;

}  // namespace nepho
