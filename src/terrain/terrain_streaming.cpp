// The ground while tiles are still being made: Terrain::prepare() without waiting for all of them, and prefetch().
#include <algorithm>
#include <chrono>

#include "base/parallel.h"
#include "base/seconds_since.h"
#include "terrain/terrain.h"
#include "terrain/terrain_view.h"

namespace nepho {

namespace {

/// A late tile takes its own shape over this many frames.
constexpr float kArrivalFrames = 8.0f;
/// Share of the slots that a view may use; the others hold what comes next.
constexpr double kMostUsed = 0.8;
constexpr uint64_t kUploadBytesPerFrame = 8u << 20;
/// After this time the first picture does without what takes longer.
constexpr double kRootPatience_s = 0.5;
constexpr size_t kMostResidentMetas = 4 * TileAtlas::kMostSlots;

/// Tiles as far as they are on the GPU.
class ResidentTiles final : public TileMetaSource {
 public:
  ResidentTiles(const TileBuilder& builder, TileAtlas& atlas, const std::unordered_map<TileId, TileMeta>& metas,
                bool arrive_slowly)
      : builder_(builder), atlas_(atlas), metas_(metas), arrive_slowly_(arrive_slowly) {}

  double least_error_m(const TileId& tile) const override { return builder_.least_error_m(tile); }
  HeightRange height_range() const override { return builder_.height_range(); }
  void prepare(std::span<const TileId>) override {}
  const TileMeta& meta(const TileId& tile) override { return metas_.at(tile); }
  bool step_by_step() const override { return true; }
  bool ready(const TileId& tile) override {
    if (!atlas_.find(tile)) return false;
    ++used_;
    return true;
  }
  void want(const TileId& tile, double urgency) override { wanted_.push_back({tile, urgency}); }
  float arrival(const TileId& tile) const override {
    return arrive_slowly_ ? std::min(1.0f, static_cast<float>(atlas_.age(tile)) / kArrivalFrames) : 1.0f;
  }

  size_t used() const { return used_; }
  /// What is missing: coarse before fine, and what shows most first.
  std::vector<TileId> wanted() {
    std::sort(wanted_.begin(), wanted_.end(), [](const Wish& a, const Wish& b) {
      if (a.tile.level != b.tile.level) return a.tile.level < b.tile.level;
      return a.urgency != b.urgency ? a.urgency > b.urgency : a.tile < b.tile;
    });
    std::vector<TileId> tiles;
    for (const Wish& w : wanted_)
      if (tiles.empty() || tiles.back() != w.tile) tiles.push_back(w.tile);
    return tiles;
  }

 private:
  struct Wish {
    TileId tile;
    double urgency;
  };
  const TileBuilder& builder_;
  TileAtlas& atlas_;
  const std::unordered_map<TileId, TileMeta>& metas_;
  bool arrive_slowly_;
  size_t used_ = 0;
  std::vector<Wish> wanted_;
};

}  // namespace

void Terrain::start_loader() {
  if (loader_) return;
  // All slots at once: growing would forget what is drawn.
  atlas_.grow(atlas_.most_slots());
  const size_t threads = std::max(1u, std::thread::hardware_concurrency() / 2);
  loader_ = std::make_unique<TileLoader>(builder_, threads, caches_.memory);
}

void Terrain::load_roots() {
  std::vector<TileId> missing;
  for (uint32_t x = 0; x < 2; ++x)
    if (const TileId root{0, x, 0}; !atlas_.find(root)) missing.push_back(root);
  if (missing.empty()) return;
  const auto start = std::chrono::steady_clock::now();
  const auto all_there = [&] {
    return std::all_of(missing.begin(), missing.end(),
                       [&](const TileId& root) { return loader_->find(root) != nullptr; });
  };
  loader_->request(missing);
  while (!all_there() && seconds_since(start) < kRootPatience_s) loader_->wait(kRootPatience_s / 10.0);
  for (const TileId& root : missing) {
    if (const std::shared_ptr<const LoadedTile> loaded = loader_->find(root)) {
      put(root, *loaded);
      continue;
    }
    const TileReads no_data(TileReads::Extent::nothing);
    const OneCore this_thread;
    put(root, {builder_.make_meta(root), builder_.make_data(root), true});
    unfinished_[root] = Unfinished::blank;
  }
}

void Terrain::put(const TileId& tile, const LoadedTile& loaded) {
  const TileAtlas::Upload upload{tile, &loaded.data};
  atlas_.upload(std::span(&upload, 1));
  if (resident_metas_.size() >= kMostResidentMetas)
    std::erase_if(resident_metas_, [&](const auto& m) { return !atlas_.peek(m.first); });
  resident_metas_[tile] = loaded.meta;
  uploaded_bytes_ += TileAtlas::slot_bytes();
  if (loaded.draft)
    unfinished_[tile] = Unfinished::draft;
  else
    unfinished_.erase(tile);
}

void Terrain::select_streaming(const TerrainView& wanted_view, const TerrainWait& wait) {
  start_loader();
  load_roots();
  const auto start = std::chrono::steady_clock::now();
  error_scale_ = std::max(1.0, error_scale_ * 0.99);
  const uint64_t loaded_before = loader_->stats().loaded;
  for (;;) {
    const auto selecting = std::chrono::steady_clock::now();
    for (;;) {
      TerrainView view = wanted_view;
      view.screen_error_px *= error_scale_;
      ResidentTiles tiles(builder_, atlas_, resident_metas_, wait.at_most_s == 0.0);
      selected_ = select_tiles(view, tiles);
      wanted_ = tiles.wanted();
      if (static_cast<double>(tiles.used()) <= kMostUsed * atlas_.slots()) break;
      error_scale_ *= 1.1;
    }
    warn_of_error(wanted_view.screen_error_px * error_scale_);
    stats_.select_ms += 1e3 * seconds_since(selecting);
    const auto uploading = std::chrono::steady_clock::now();
    fetch(wanted_);
    stats_.upload_ms += 1e3 * seconds_since(uploading);
    const double left_s = wait.at_most_s - seconds_since(start);
    if ((wanted_.empty() && unfinished_in_view() == 0) || left_s <= 0.0) break;
    if (wait.on_progress) {
      const TileLoader::Stats at = loader_->stats();
      wait.on_progress(at.loaded - loaded_before, at.loaded - loaded_before + at.waiting);
    }
    if (uploaded_bytes_ == 0) loader_->wait(std::min(left_s, 0.1));
    uploaded_bytes_ = 0;
    atlas_.begin_frame();
  }
  stats_.tiles_missing = static_cast<uint32_t>(wanted_.size() + unfinished_in_view());
}

size_t Terrain::unfinished_in_view() const {
  return static_cast<size_t>(std::count_if(selected_.begin(), selected_.end(),
                                           [&](const SelectedTile& s) { return unfinished_.contains(s.tile); }));
}

void Terrain::fetch(const std::vector<TileId>& wanted) {
  std::vector<TileId> missing;
  for (const TileId& tile : wanted) {
    if (atlas_.peek(tile)) continue;
    const std::shared_ptr<const LoadedTile> loaded = loader_->find(tile);
    if (!loaded) {
      missing.push_back(tile);
      continue;
    }
    if (uploaded_bytes_ >= kUploadBytesPerFrame || !atlas_.has_room()) continue;
    put(tile, *loaded);
    ++stats_.tiles_loaded;
  }
  // What is in the atlas as a draft, or without data, is made anew once nothing is missing.
  std::erase_if(unfinished_, [&](const auto& entry) { return !atlas_.peek(entry.first); });
  std::vector<TileId> drafts;
  for (const auto& [tile, state] : std::unordered_map(unfinished_)) {
    const std::shared_ptr<const LoadedTile> loaded = loader_->find(tile);
    if (!loaded)
      missing.insert(missing.begin(), tile);
    else if ((state == Unfinished::blank || !loaded->draft) && uploaded_bytes_ < kUploadBytesPerFrame)
      put(tile, *loaded);
    if (loaded && loaded->draft) drafts.push_back(tile);
  }
  std::sort(drafts.begin(), drafts.end(), [](const TileId& a, const TileId& b) { return b < a; });  // small ones first
  loader_->request(missing);
  loader_->finish(drafts);
}

void Terrain::prefetch(const FrameInfo& frame) {
  start_loader();
  load_roots();
  ResidentTiles tiles(builder_, atlas_, resident_metas_, false);
  TerrainView view = view_of(frame, params_, ground_.deepest_land_m());
  view.screen_error_px *= error_scale_;
  (void)select_tiles(view, tiles);
  std::vector<TileId> wanted = wanted_;
  for (const TileId& tile : tiles.wanted()) wanted.push_back(tile);
  fetch(wanted);
}

}  // namespace nepho
