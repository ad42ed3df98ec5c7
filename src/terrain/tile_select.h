#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geo/lonlat_tiles.h"
#include "terrain/tile_volume.h"

namespace nepho {

/// Heights above the ellipsoid, m.
struct HeightRange {
  double min_m = 0.0, max_m = 0.0;
};

/// What selection must know of a tile before it is loaded.
struct TileMeta {
  HeightRange heights;   ///< that all of the tile's surface keeps to
  double error_m = 0.0;  ///< how far the drawn surface may be from the data; texture needs included
  TileVolume volume;
};

/// Where selection gets it from.
class TileMetaSource {
 public:
  virtual ~TileMetaSource() = default;
  /// A lower bound of meta().error_m that needs no data: tiles that it splits anyway are never looked at.
  virtual double least_error_m(const TileId& tile) const = 0;
  /// Heights above the ellipsoid that the whole surface keeps to.
  virtual HeightRange height_range() const = 0;
  /// Makes meta() cheap for these tiles; called with many at once.
  virtual void prepare(std::span<const TileId> tiles) = 0;
  virtual const TileMeta& meta(const TileId& tile) = 0;
};

/// A tile to be drawn, and which parts of its border are a coarser neighbour's (kEdge..., kCorner... of tile_mesh.h).
struct SelectedTile {
  TileId tile;
  uint8_t edges = 0;
  uint8_t quarters = 15;  ///< which quarters may be visible: bit 0 north-west, 1 north-east, 2 south-west, 3 south-east
  double distance_m = 0.0;  ///< from the camera to its box
};

/// Deepest level that is ever drawn: 1.2 m between vertices.
inline constexpr uint32_t kMaxTerrainLevel = 18;

/// False where tiles are thin wedges: around a pole every level doubles the number of tiles that meet there, so within
/// 2.8 degrees tiles stay at level 6 (4.9 km between vertices), and up to 5.6 degrees the levels rise one by one.
bool may_split(const TileId& tile);

/// The tiles that show the surface: each within the wanted screen error, culled by frustum and horizon, touching tiles
/// at most one level apart (corners included). Nearest first; the same view gives the same list.
std::vector<SelectedTile> select_tiles(const TerrainView& view, TileMetaSource& source,
                                       uint32_t max_level = kMaxTerrainLevel);

}  // namespace nepho
