#pragma once
#include <optional>
#include <vector>

#include "geo/lonlat_tiles.h"

namespace nepho {

/// The pixels of a raster, as far as they matter to where texels lie.
struct PixelLattice {
  double west_deg = -180.0, north_deg = 90.0;  ///< outer edges
  double lon_deg = 1.0, lat_deg = 1.0;         ///< size of a pixel
  double oversampling = 1.0;                   ///< RasterInfo::oversampling
  double middle_deg = 0.0;                     ///< longitude of the raster's middle
};

/// Where the texels of a tile's imagery lie: the tile and a border of 4 texels at least on every side, in an image of
/// kTerrainImageryTexels a side. Texels are the pixels of the picture, or 2^n x 2^n of them, or n parts of one that
/// begin at its centre: what the GPU interpolates between them is then what lies between the picture's own pixels.
/// Neighbours of one level have the same texels.
struct ImageryGrid {
  double west_deg = 0.0, north_deg = 0.0;         ///< outer edges of the first texel
  double lon_step_deg = 0.0, lat_step_deg = 0.0;  ///< size of a texel
  double coarse_deg = 0.0;   ///< size of a texel that is larger than a pixel; 0: the picture has no more detail
  double source_deg = 0.0;   ///< size of a pixel of the source (before oversampling): the larger side
  double detail_log2 = 0.0;  ///< log2 of source_deg in texels (geometric mean of their sides); 0 and more
  bool parts = false;        ///< texels are parts of a pixel: the parent says the same of colours

  double texel_deg() const;  ///< the larger side
  std::vector<double> lats_deg() const;
  std::vector<double> lons_deg() const;
};

/// `finest`: of the picture with the smallest pixels on the tile; none where there is none.
ImageryGrid imagery_grid(const TileId& tile, const std::optional<PixelLattice>& finest);

}  // namespace nepho
