#include "terrain/tile_select.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "terrain/tile_mesh.h"

namespace nepho {

namespace {

/// Nearer than this the error does not grow any more, m.
constexpr double kNearestDistance = 0.5;

class Selection {
 public:
  Selection(const TerrainView& view, TileMetaSource& source, uint32_t max_level)
      : view_(view), source_(source), max_level_(max_level) {}

  std::vector<SelectedTile> run() {
    refine();
    while (balance_once()) {
    }
    std::vector<SelectedTile> out;
    out.reserve(leaves_.size());
    for (const auto& [tile, distance] : leaves_) out.push_back({tile, edges_of(tile), quarters_of(tile), distance});
    std::sort(out.begin(), out.end(), [](const SelectedTile& a, const SelectedTile& b) {
      return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.tile < b.tile;
    });
    return out;
  }

 private:
  bool hidden(const TileVolume& volume) const { return outside_frustum(volume, view_) || below_horizon(volume, view_); }

  /// A tile on the way down, with what is known of its heights so far.
  struct Candidate {
    TileId tile;
    HeightRange heights;
    TileVolume volume;
  };

  /// Children that may be visible by their parent's heights: most hidden tiles are found without looking at their data.
  void add_children(const Candidate& parent, std::vector<Candidate>& out) const {
    for (uint32_t i = 0; i < 4; ++i) add_if_visible(tile_child(parent.tile, i), parent.heights, out);
  }
  void add_if_visible(const TileId& tile, const HeightRange& heights, std::vector<Candidate>& out) const {
    const TileVolume volume = make_tile_volume(tile, heights.min_m, heights.max_m, view_.ellipsoid);
    if (!hidden(volume)) out.push_back({tile, heights, volume});
  }

  double limit_m(const TileVolume& volume) const {
    const double distance = std::max(volume.distance_m(view_.camera_ecef_m), kNearestDistance);
    return view_.screen_error_px * view_.pixel_angle_rad * distance;
  }

  /// Looks at the data of candidates and drops those that turn out hidden.
  void look_at(std::vector<Candidate>& candidates) {
    std::vector<TileId> tiles;
    for (const Candidate& c : candidates) tiles.push_back(c.tile);
    source_.prepare(tiles);
    std::erase_if(candidates, [&](Candidate& c) {
      const TileMeta& m = source_.meta(c.tile);
      c.heights = m.heights;
      c.volume = m.volume;
      return hidden(c.volume);
    });
  }

  void add_leaf(const TileId& tile, double distance) {
    leaves_.emplace(tile, distance);
    for (TileId t = tile; t.level > 0;) {
      t = *tile_parent(t);
      if (!inner_.insert(t).second) break;
    }
  }

  void refine() {
    std::vector<Candidate> candidates;
    for (uint32_t x = 0; x < 2; ++x) add_if_visible({0, x, 0}, source_.height_range(), candidates);
    while (!candidates.empty()) {
      std::vector<Candidate> next, unsure;
      for (const Candidate& c : candidates) {
        const bool can_split = c.tile.level < max_level_ && may_split(c.tile);
        if (can_split && source_.least_error_m(c.tile) > limit_m(c.volume))
          add_children(c, next);
        else
          unsure.push_back(c);
      }
      look_at(unsure);
      for (const Candidate& c : unsure) {
        const bool can_split = c.tile.level < max_level_ && may_split(c.tile);
        if (can_split && source_.meta(c.tile).error_m > limit_m(c.volume))
          add_children(c, next);
        else
          add_leaf(c.tile, c.volume.distance_m(view_.camera_ecef_m));
      }
      candidates = std::move(next);
    }
  }

  /// Splits every leaf that touches tiles two or more levels deeper. False when there is none.
  bool balance_once() {
    std::vector<TileId> split;
    for (const auto& [tile, distance] : leaves_) {
      // Deeper tiles inside a neighbour show as an inner tile among its children.
      bool too_coarse = false;
      for (int dy = -1; dy <= 1 && !too_coarse; ++dy)
        for (int dx = -1; dx <= 1 && !too_coarse; ++dx) {
          if (dx == 0 && dy == 0) continue;
          const auto neighbour = tile_neighbour(tile, dx, dy);
          if (!neighbour || !inner_.contains(*neighbour)) continue;
          for (uint32_t i = 0; i < 4; ++i) {
            const int cx = static_cast<int>(i & 1), cy = static_cast<int>(i >> 1);
            // Only the children that touch this tile.
            if ((dx == 1 && cx != 0) || (dx == -1 && cx != 1) || (dy == 1 && cy != 0) || (dy == -1 && cy != 1))
              continue;
            if (inner_.contains(tile_child(*neighbour, i))) too_coarse = true;
          }
        }
      if (too_coarse) split.push_back(tile);
    }
    if (split.empty()) return false;
    std::sort(split.begin(), split.end());
    for (const TileId& tile : split) {
      leaves_.erase(tile);
      inner_.insert(tile);
    }
    std::vector<Candidate> children;
    for (const TileId& tile : split) add_children({tile, source_.meta(tile).heights, {}}, children);
    look_at(children);
    for (const Candidate& c : children) add_leaf(c.tile, c.volume.distance_m(view_.camera_ecef_m));
    return true;
  }

  bool coarser_at(const TileId& tile, int dx, int dy) const {
    if (tile.level == 0) return false;
    const auto neighbour = tile_neighbour(tile, dx, dy);
    return neighbour && leaves_.contains(*tile_parent(*neighbour));
  }

  uint8_t edges_of(const TileId& tile) const {
    const bool n = coarser_at(tile, 0, -1), e = coarser_at(tile, 1, 0), s = coarser_at(tile, 0, 1),
               w = coarser_at(tile, -1, 0);
    uint32_t bits = (n ? kEdgeNorth : 0u) | (e ? kEdgeEast : 0u) | (s ? kEdgeSouth : 0u) | (w ? kEdgeWest : 0u);
    if (n || w || coarser_at(tile, -1, -1)) bits |= kCornerNorthWest;
    if (n || e || coarser_at(tile, 1, -1)) bits |= kCornerNorthEast;
    if (s || e || coarser_at(tile, 1, 1)) bits |= kCornerSouthEast;
    if (s || w || coarser_at(tile, -1, 1)) bits |= kCornerSouthWest;
    return static_cast<uint8_t>(bits);
  }

  uint8_t quarters_of(const TileId& tile) {
    const HeightRange heights = source_.meta(tile).heights;
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 4; ++i)
      if (!hidden(make_tile_volume(tile_child(tile, i), heights.min_m, heights.max_m, view_.ellipsoid)))
        bits |= 1u << i;
    return static_cast<uint8_t>(bits);
  }

  const TerrainView& view_;
  TileMetaSource& source_;
  uint32_t max_level_;
  std::unordered_map<TileId, double> leaves_;  // with their distance
  std::unordered_set<TileId> inner_;           // tiles that have leaves below them
};

}  // namespace

bool may_split(const TileId& tile) {
  constexpr uint32_t kPoleLevel = 6;
  if (tile.level < kPoleLevel) return true;
  const uint32_t from_pole = std::min(tile.y, tile_rows(tile.level) - 1 - tile.y);
  return from_pole > (2u << (tile.level - kPoleLevel)) - 2;
}

std::vector<SelectedTile> select_tiles(const TerrainView& view, TileMetaSource& source, uint32_t max_level) {
  return Selection(view, source, max_level).run();
}

}  // namespace nepho
