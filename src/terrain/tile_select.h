#pragma once
#include <array>
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
  /// Of a tile that prepare() was called with.
  virtual const TileMeta& meta(const TileId& tile) = 0;

  /// False while a tile cannot be drawn; its parent is drawn instead. With streaming every tile from the roots down
  /// has to be ready; without, all of them always are.
  virtual bool ready(const TileId&) { return true; }
  /// Told of tiles that are wanted and not ready, with the error of their parent relative to what is allowed.
  virtual void want(const TileId&, double /*urgency*/) {}
  /// True when selection has to go through every level (streaming).
  virtual bool step_by_step() const { return false; }
  /// How far a tile that has arrived late may differ from its parent, 0..1.
  virtual float arrival(const TileId&) const { return 1.0f; }
};

/// A tile to be drawn, and which parts of its border are a coarser neighbour's (kEdge..., kCorner... of tile_mesh.h).
struct SelectedTile {
  TileId tile;
  uint8_t edges = 0;
  uint8_t quarters = 15;  ///< which quarters may be visible: bit 0 north-west, 1 north-east, 2 south-west, 3 south-east
  double distance_m = 0.0;  ///< from the camera to its box
  /// How much of its own shape the tile has: 0 the parent's, 1 all of it. Grows as the camera comes nearer, so that
  /// levels change without a step.
  float morph = 1.0f;
  std::array<float, 4> edge_morph{1, 1, 1, 1};  ///< the same of its edges (north, east, south, west), corners excluded
  std::array<float, 4> corner_morph{1, 1, 1, 1};  ///< and its corners (north-west, north-east, south-east, south-west)
};

/// Deepest level that is ever drawn: 1.2 m between vertices.
inline constexpr uint32_t kMaxTerrainLevel = 18;

/// Children have their own shape in full when their parent's error is this many times what is allowed. A tile only
/// splits when those around it have reached that: what touches a finer tile never moves.
inline constexpr double kMorphRange = 1.4;

/// False where tiles are thin wedges: around a pole every level doubles the number of tiles that meet there, so within
/// 2.8 degrees tiles stay at level 6 (4.9 km between vertices), and up to 5.6 degrees the levels rise one by one.
bool may_split(const TileId& tile);

/// The tiles that show the surface: each within the wanted screen error, culled by frustum and horizon, touching tiles
/// at most one level apart (corners included). Nearest first; the same view gives the same list. Shapes change
/// continuously with the view (docs/terrain.md, 'Morphing').
std::vector<SelectedTile> select_tiles(const TerrainView& view, TileMetaSource& source,
                                       uint32_t max_level = kMaxTerrainLevel);

}  // namespace nepho
