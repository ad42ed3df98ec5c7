#include "terrain/tile_select.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "base/error.h"
#include "terrain/tile_mesh.h"

namespace nepho {

namespace {

/// Nearer than this the error does not grow any more, m.
constexpr double kNearestDistance = 0.5;
/// Tiles whose least error is this many times what is allowed are split without a look at their data.
constexpr double kSurelySplit = 4.0;

/// A tile that may be visible, somewhere between the roots and the deepest tiles of the picture.
struct Node {
  HeightRange heights;
  TileVolume volume;
  double distance_m = 0.0;
  double excess = 0.0;  ///< its error relative to what is allowed: above 1 it is split
  double limit_below = std::numeric_limits<double>::infinity();  ///< of its children's excess
  bool split = false;
  bool drawn = false;
  float morph = 1.0f;
};

struct Step {
  int dx, dy;
};
constexpr Step kAround[8] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}, {-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

/// What a tile's excess asks of the coarser ones around it: where it is split (above 1), theirs is kMorphRange times as
/// much; shortly before, they begin to split themselves.
double asked_around(double excess) {
  constexpr double kBegin = 0.85;
  if (excess >= 1.0) return excess * kMorphRange;
  return excess > kBegin ? 1.0 + (kMorphRange - 1.0) * (excess - kBegin) / (1.0 - kBegin) : 0.0;
}

class Selection {
 public:
  Selection(const TerrainView& view, TileMetaSource& source, uint32_t max_level)
      : view_(view), source_(source), max_level_(max_level), levels_(max_level + 1) {}

  std::vector<SelectedTile> run() {
    std::vector<Candidate> roots;
    for (uint32_t x = 0; x < 2; ++x) add_candidate({0, x, 0}, source_.height_range(), kNoLimit, roots);
    refine(std::move(roots));
    raise();
    settle();
    std::vector<SelectedTile> out;
    for (auto& [tile, node] : nodes_)
      if (node.drawn) out.push_back(describe(tile, node));
    std::sort(out.begin(), out.end(), [](const SelectedTile& a, const SelectedTile& b) {
      return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.tile < b.tile;
    });
    return out;
  }

 private:
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();

  struct Candidate {
    TileId tile;
    HeightRange heights;
    TileVolume volume;
    double limit;  // of its excess
  };

  bool hidden(const TileVolume& volume) const { return outside_frustum(volume, view_) || below_horizon(volume, view_); }
  bool can_split(const TileId& tile) const { return tile.level < max_level_ && may_split(tile); }

  /// Adds a tile unless its parent's heights show it hidden: most hidden tiles are found without looking at their data.
  void add_candidate(const TileId& tile, const HeightRange& heights, double limit, std::vector<Candidate>& out) const {
    const TileVolume volume = make_tile_volume(tile, heights.min_m, heights.max_m, view_.ellipsoid);
    if (!hidden(volume)) out.push_back({tile, heights, volume, limit});
  }

  /// Splits a node unless one of its children that may be visible is not ready; adds these to `out`. All of them may
  /// turn out hidden.
  void split(const TileId& tile, Node& node, std::vector<Candidate>& all) {
    std::vector<Candidate> out;
    for (uint32_t i = 0; i < 4; ++i) add_candidate(tile_child(tile, i), node.heights, node.limit_below, out);
    bool all_ready = true;
    for (const Candidate& c : out)
      if (!source_.ready(c.tile)) {
        all_ready = false;
        source_.want(c.tile, node.excess);
      }
    node.split = all_ready;
    if (all_ready) all.insert(all.end(), out.begin(), out.end());
  }

  double excess_of(double error_m, const TileVolume& volume) const {
    const double distance = std::max(volume.distance_m(view_.camera_ecef_m), kNearestDistance);
    return error_m / (view_.screen_error_px * view_.pixel_angle_rad * distance);
  }

  void add_node(const Candidate& c, double excess, bool sure) {
    Node node{.heights = c.heights, .volume = c.volume};
    node.distance_m = c.volume.distance_m(view_.camera_ecef_m);
    node.excess = excess;
    // A child far worse than its parent would come with its own children at once; it waits for the parent's.
    node.limit_below = sure ? excess / kMorphRange : kNoLimit;
    nodes_.emplace(c.tile, node);
    levels_[c.tile.level].push_back(c.tile);
  }

  /// Makes nodes of candidates; `surely` split ones without a look at their data. Hidden ones are dropped.
  void add_nodes(std::vector<Candidate> candidates) {
    std::erase_if(candidates, [&](const Candidate& c) { return nodes_.contains(c.tile); });
    std::vector<Candidate> unsure;
    std::vector<TileId> tiles;
    for (const Candidate& c : candidates) {
      const double least = excess_of(source_.least_error_m(c.tile), c.volume);
      if (!source_.step_by_step() && can_split(c.tile) && least >= kSurelySplit) {
        add_node(c, least, false);
      } else {
        unsure.push_back(c);
        tiles.push_back(c.tile);
      }
    }
    source_.prepare(tiles);
    for (Candidate& c : unsure) {
      const TileMeta& meta = source_.meta(c.tile);
      c.heights = meta.heights;
      c.volume = meta.volume;
      if (!hidden(c.volume)) add_node(c, std::min(excess_of(meta.error_m, c.volume), c.limit), true);
    }
  }

  /// Splits the nodes of a level that need it and makes their children.
  void split_level(uint32_t level) {
    std::vector<Candidate> next;
    for (const TileId& tile : levels_[level]) {
      Node& node = nodes_.at(tile);
      if (node.split || node.excess <= 1.0 || !can_split(tile)) continue;
      split(tile, node, next);
    }
    add_nodes(std::move(next));
  }

  void refine(std::vector<Candidate> roots) {
    add_nodes(std::move(roots));
    for (uint32_t level = 0; level < max_level_ && !levels_[level].empty(); ++level) split_level(level);
  }

  /// The node of a tile whose neighbours need it, made on the way where a coarser tile lies over it; null: hidden.
  Node* node_at(const TileId& tile, double excess) {
    const auto found = nodes_.find(tile);
    if (found != nodes_.end()) return &found->second;
    const auto parent = tile_parent(tile);
    if (!parent) return nullptr;
    const double asked = asked_around(excess);
    Node* above = node_at(*parent, asked);
    if (!above || above->split || !can_split(*parent)) return nullptr;
    above->excess = std::max(above->excess, asked);
    std::vector<Candidate> children;
    split(*parent, *above, children);
    add_nodes(std::move(children));
    const auto made = nodes_.find(tile);
    return made != nodes_.end() ? &made->second : nullptr;
  }

  /// From the finest level up: around a tile that is split everything one level coarser is split, too, and has been
  /// for long enough to have changed its shape.
  void raise() {
    for (uint32_t level = max_level_; level > 0; --level) {
      for (size_t i = 0; i < levels_[level].size(); ++i) {
        const TileId tile = levels_[level][i];
        const double excess = asked_around(nodes_.at(tile).excess);
        if (excess <= 1.0) continue;
        for (const Step& s : kAround)
          if (const auto neighbour = tile_neighbour(tile, s.dx, s.dy))
            if (Node* coarse = node_at(*tile_parent(*neighbour), excess))
              coarse->excess = std::max(coarse->excess, excess);
      }
      split_level(level - 1);
    }
  }

  bool drawn(const TileId& tile) const {
    const auto found = nodes_.find(tile);
    return found != nodes_.end() && found->second.drawn;
  }

  /// True when a tile around this one is drawn at a coarser level.
  bool coarser_around(const TileId& tile) const {
    for (const Step& s : kAround) {
      const auto neighbour = tile_neighbour(tile, s.dx, s.dy);
      if (!neighbour) continue;
      for (auto above = tile_parent(*neighbour); above; above = tile_parent(*above))
        if (drawn(*above)) return true;
    }
    return false;
  }

  /// From the roots down: what is drawn, and in which shape. Where tiles are not ready, finer ones beside them wait.
  void settle() {
    std::vector<TileId> now = levels_[0];
    while (!now.empty()) {
      std::vector<TileId> next;
      // Drawn ones first: the others may only go two levels deeper than what is around them.
      for (const TileId& tile : now) {
        Node& node = nodes_.at(tile);
        if (const auto parent = tile_parent(tile)) {
          const double grown = (nodes_.at(*parent).excess - 1.0) / (kMorphRange - 1.0);
          node.morph = std::min(static_cast<float>(std::clamp(grown, 0.0, 1.0)), source_.arrival(tile));
        }
        node.drawn = !node.split || coarser_around(tile);
      }
      for (const TileId& tile : now) {
        Node& node = nodes_.at(tile);
        node.split = !node.drawn;
        for (uint32_t i = 0; node.split && i < 4; ++i)
          if (nodes_.contains(tile_child(tile, i))) next.push_back(tile_child(tile, i));
      }
      now = std::move(next);
    }
  }

  bool coarser_at(const TileId& tile, const Step& s) const {
    if (tile.level == 0) return false;
    const auto neighbour = tile_neighbour(tile, s.dx, s.dy);
    return neighbour && drawn(*tile_parent(*neighbour));
  }

  /// The shape that a border has from what lies at `steps` beside it: in full where finer tiles touch it (these have
  /// exactly this level's vertices there), else the least of those that share it.
  float shared_morph(const TileId& tile, std::span<const Step> steps) const {
    float least = nodes_.at(tile).morph;
    for (const Step& s : steps) {
      const auto neighbour = tile_neighbour(tile, s.dx, s.dy);
      if (!neighbour) continue;
      const auto found = nodes_.find(*neighbour);
      if (found == nodes_.end()) continue;
      if (found->second.split) return 1.0f;
      if (found->second.drawn) least = std::min(least, found->second.morph);
    }
    return least;
  }

  SelectedTile describe(const TileId& tile, const Node& node) const {
    SelectedTile out{.tile = tile, .distance_m = node.distance_m, .morph = node.morph};
    bool coarser[8];
    for (size_t i = 0; i < 8; ++i) coarser[i] = coarser_at(tile, kAround[i]);
    constexpr uint32_t kEdges[4] = {kEdgeNorth, kEdgeEast, kEdgeSouth, kEdgeWest};
    constexpr uint32_t kCorners[4] = {kCornerNorthWest, kCornerNorthEast, kCornerSouthEast, kCornerSouthWest};
    uint32_t edges = 0;
    for (size_t i = 0; i < 4; ++i) {
      if (coarser[i]) edges |= kEdges[i];
      out.edge_morph[i] = shared_morph(tile, std::span(&kAround[i], 1));
      // Corner i lies between edges i - 1 and i, north-west first.
      const size_t before = (i + 3) % 4;
      if (coarser[i] || coarser[before] || coarser[4 + i]) edges |= kCorners[i];
      const Step around[3] = {kAround[before], kAround[i], kAround[4 + i]};
      out.corner_morph[i] = shared_morph(tile, around);
    }
    out.edges = static_cast<uint8_t>(edges);
    out.quarters = 0;
    for (uint32_t i = 0; i < 4; ++i)
      if (!hidden(make_tile_volume(tile_child(tile, i), node.heights.min_m, node.heights.max_m, view_.ellipsoid)))
        out.quarters |= static_cast<uint8_t>(1u << i);
    return out;
  }

  const TerrainView& view_;
  TileMetaSource& source_;
  uint32_t max_level_;
  std::unordered_map<TileId, Node> nodes_;
  std::vector<std::vector<TileId>> levels_;  // nodes in the order they were made
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
