#include "rasters/raster_clusters.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace nepho {

namespace {

constexpr double kTouch_px = 1.5, kLikeSizes = 4.0;

bool alike(double a, double b) { return std::max(a, b) < kLikeSizes * std::min(a, b); }

bool touch(const ClusterTile& a, const ClusterTile& b, double shift) {
  const double x = kTouch_px * std::max(a.dx, b.dx), y = kTouch_px * std::max(a.dy, b.dy);
  return b.west + shift <= a.east + x && b.east + shift >= a.west - x && b.south <= a.north + y &&
         b.north >= a.south - y && alike(a.dx, b.dx) && alike(a.dy, b.dy);
}

/// Disjoint sets of 0..n-1.
class Sets {
 public:
  explicit Sets(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), size_t{0}); }
  size_t find(size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(size_t a, size_t b) { parent_[std::max(find(a), find(b))] = std::min(find(a), find(b)); }

 private:
  std::vector<size_t> parent_;
};

/// By set; ascending.
std::vector<std::vector<size_t>> listed(Sets& sets, size_t count) {
  std::map<size_t, std::vector<size_t>> by_root;
  for (size_t i = 0; i < count; ++i) by_root[sets.find(i)].push_back(i);
  std::vector<std::vector<size_t>> out;
  for (auto& [root, members] : by_root) out.push_back(std::move(members));
  return out;
}

/// Joins what is of like resolution and in the same cell of a lattice of n x n over everything.
void join_by_cells(std::span<const ClusterTile> tiles, int n, Sets& sets) {
  ClusterTile all = tiles[0];
  for (const ClusterTile& t : tiles) {
    all.west = std::min(all.west, t.west);
    all.east = std::max(all.east, t.east);
    all.south = std::min(all.south, t.south);
    all.north = std::max(all.north, t.north);
  }
  std::map<std::tuple<int, int, int>, size_t> first;
  for (size_t i = 0; i < tiles.size(); ++i) {
    const ClusterTile& t = tiles[i];
    const auto cell = [n](double at, double from, double to) {
      return std::clamp(static_cast<int>(n * (at - from) / (to - from)), 0, n - 1);
    };
    const std::tuple key{cell(0.5 * (t.west + t.east), all.west, all.east),
                         cell(0.5 * (t.south + t.north), all.south, all.north),
                         static_cast<int>(std::floor(std::log(t.dx) / std::log(kLikeSizes)))};
    sets.join(first.emplace(key, i).first->second, i);
  }
}

}  // namespace

std::vector<std::vector<size_t>> cluster_tiles(std::span<const ClusterTile> tiles, double around) {
  if (tiles.empty()) return {};
  std::vector<size_t> by_west(tiles.size());
  std::iota(by_west.begin(), by_west.end(), size_t{0});
  std::ranges::stable_sort(by_west, {}, [&](size_t i) { return tiles[i].west; });
  double widest_px = 0.0;
  for (const ClusterTile& t : tiles) widest_px = std::max(widest_px, t.dx);
  Sets sets(tiles.size());
  for (size_t a = 0; a < by_west.size(); ++a) {
    const ClusterTile& tile = tiles[by_west[a]];
    const double reach = tile.east + kTouch_px * widest_px;
    for (size_t b = a + 1; b < by_west.size() && tiles[by_west[b]].west <= reach; ++b)
      if (touch(tile, tiles[by_west[b]], 0.0)) sets.join(by_west[a], by_west[b]);
    for (size_t b = 0; around > 0.0 && b < by_west.size() && tiles[by_west[b]].west + around <= reach; ++b)
      if (touch(tile, tiles[by_west[b]], around)) sets.join(by_west[a], by_west[b]);
  }
  std::vector<std::vector<size_t>> clusters = listed(sets, tiles.size());
  for (int n = 32; clusters.size() > kMostClusters && n >= 1; n /= 2) {
    join_by_cells(tiles, n, sets);
    clusters = listed(sets, tiles.size());
  }
  return clusters;
}

}  // namespace nepho
