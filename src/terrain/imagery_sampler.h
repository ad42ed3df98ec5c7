#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "geo/lonlat_tiles.h"
#include "io/raster.h"
#include "terrain/block_cache.h"
#include "terrain/height_sampler.h"
#include "terrain/imagery_grid.h"

namespace nepho {

/// How much of a grid a raster covers.
enum class RasterCoverage { none, some, all };

/// Lays one raster over `rgbx` (four floats a place, the fourth left alone) by the bilinear weight of its valid pixels.
RasterCoverage lay_over(const BlockCache& raster, uint32_t reduction, std::span<const double> lat_deg,
                        std::span<const double> lon_deg, float* rgbx);

/// How surely a colour (sRGB, 0..255) over water is ice and not water: positive for ice, continuous. Ice is bright and
/// hardly coloured, and lies beyond 45 degrees of latitude: nearer to the equator what is white over the sea are
/// clouds.
float ice_field(const float* rgb, double lat_deg);
/// How surely a colour (sRGB, 0..255) is of land, shoals or clouds and not of deep water: positive where it is bright,
/// or less blue than red or green; continuous.
float shore_field(const float* rgb);
/// Nearer to the equator than this there is no ice on water, degrees.
inline constexpr double kLeastIceLatitude_deg = 45.0;

/// Colours from a stack of imagery rasters, bottom first; no data shows what lies below, and below everything is an
/// even grey.
///
/// The bottom raster, where it spans the globe, knows no coast finer than its own texels: its ocean colours would rim
/// the land. Its texels on water or next to it are therefore painted over with the land's colours around them, block
/// by block; those that show ice keep theirs.
class ImagerySampler {
 public:
  /// `ground` says what is sea; it must outlive this object. `bare_albedo`: of the grey below everything, 0..1.
  ImagerySampler(std::vector<std::shared_ptr<Raster>> imagery, const HeightSampler& ground, double bare_albedo = 0.2,
                 const RasterCaches& caches = {});

  /// sRGB colours, 0..255, four floats a place (the fourth is unused), row by row.
  void colours(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg, float* rgbx) const;
  /// Where pictures say more of water than elevation does: positive where they show something else, m or levels of
  /// sRGB, continuous. Ice, by ice_field() of the pictures as they are; and, in pictures four times finer than any
  /// elevation there, whatever is not deep water by shore_field(): of the mean over four pixels a side, or by far. Far
  /// below 0 where there is nothing to say.
  void over_water(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                  float* out) const;
  /// The pixels of the finest raster that shows on a tile, as far as can be told cheaply; none without any.
  std::optional<PixelLattice> finest_lattice(const TileBounds& tile) const;
  uint64_t blocks_read() const;
  /// What became of the blocks of every raster, bottom first.
  std::vector<SourceStats> source_stats() const;

 private:
  /// Whether every pixel is; false also where finding out would be dear.
  bool is_opaque(const BlockCache& layer) const;
  void lay_all(const BlockCache* bottom, std::span<const double> lat_deg, std::span<const double> lon_deg,
               double spacing_deg, float* rgbx, const std::vector<const BlockCache*>* but = nullptr) const;
  /// Layers whose white seas are no ice (has_white_seas()), found when first asked for.
  const std::vector<const BlockCache*>& maps_on_paper() const;
  const HeightSampler& ground_;
  mutable std::once_flag paper_asked_;
  mutable std::vector<const BlockCache*> paper_;
  std::vector<std::unique_ptr<BlockCache>> layers_;
  std::unique_ptr<BlockCache> bottom_as_it_is_;  // where the bottom layer is painted over; null otherwise
  std::vector<const BlockCache*> fine_;          // layers that know coasts better than elevation does
  float bare_srgb_;
  mutable std::mutex opaque_mutex_;
  mutable std::unordered_map<const BlockCache*, bool> opaque_;
};

}  // namespace nepho
