#pragma once
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "geo/geoid.h"
#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "io/raster.h"
#include "scene/scene.h"
#include "terrain/height_sampler.h"
#include "terrain/imagery_sampler.h"
#include "terrain/tile_atlas.h"
#include "terrain/tile_builder.h"
#include "terrain/tile_loader.h"
#include "terrain/tile_mesh.h"
#include "terrain/tile_select.h"

namespace nepho {

/// Rasters that the ground is made of. All may be empty: the plain ellipsoid in even grey.
struct TerrainSources {
  std::vector<std::shared_ptr<Raster>> elevation;  ///< bottom first
  bool has_default = false;                        ///< elevation[0] is the default Earth, which says what is sea
  std::vector<std::shared_ptr<Raster>> imagery;    ///< bottom first
  std::shared_ptr<Raster> night_lights;            ///< city lights on black; may be null
  std::shared_ptr<Raster> water_mask = nullptr;    ///< white: water (HeightSampler::set_water_mask); may be null
  std::shared_ptr<const Geoid> geoid;              ///< null: mean sea level is the ellipsoid
  double bare_albedo = 0.2;                        ///< of ground without imagery, 0..1
  RasterCaches caches = {};                        ///< without a memory budget: made by the terrain's parameters
};

/// What Terrain::prepare() waits for.
struct TerrainWait {
  /// True: everything that the view needs. Otherwise tiles are made in the background, and what is not there yet is
  /// covered by coarser tiles.
  bool complete = true;
  double at_most_s = 0.0;  ///< not `complete`: how long to wait for what is missing, s
  /// Told how many of the missing tiles are there.
  std::function<void(size_t done, size_t of)> on_progress = {};
};

/// The ground: a quadtree of latitude/longitude tiles over the ellipsoid (docs/terrain.md). Loads what a view needs,
/// draws it into a small G-buffer, and resolves that into images for shading. Keeps tiles from frame to frame.
class Terrain {
 public:
  Terrain(gpu::Device& device, TerrainSources sources, const TerrainParams& params);
  ~Terrain();

  /// Height of the drawn surface above the ellipsoid at full detail, m. Thread-safe.
  double ground_height_m(double lat_rad, double lon_rad) const;

  /// Selects the tiles of a view, loads and uploads what is missing. Call before add() with the same frame.
  void prepare(const FrameInfo& frame, const TerrainWait& wait = {});
  /// Makes and uploads in the background what this view will need, after what the last prepare() asked for: a later
  /// frame of a sequence.
  void prefetch(const FrameInfo& frame);

  struct Outputs {
    ImageRef depth_m;  ///< r32f: distance along the pixel's ray, m; 1e10 for the sky
    ImageRef albedo;   ///< rgba16f: linear Rec. 709; a: 0 sky, 1 land, 2 water (whose rgb is 0)
    ImageRef normal;   ///< rgba16f: unit normal, ECEF axes; of water the geodetic normal; sky tiles undefined
    /// rgba16f: night lights, linear, 1 the brightest; black without any; sky tiles undefined. Empty where it is day as
    /// far as the camera sees.
    ImageRef emission;
    /// The tiles of kPixelTile^2 pixels that show some ground, and those that do not (shaders/common/pixel_tiles.glsl).
    BufferRef surface_tiles, sky_tiles;
  };
  /// Draws what prepare() selected: passes "terrain.raster", "terrain.classify" and "terrain.resolve".
  Outputs add(FrameGraph& graph, const FrameInfo& frame) const;

  /// The surface of a selected tile as drawn: ECEF positions of its 65 x 65 grid places, m, row 0 northernmost. Makes
  /// the tile's vertices anew. Thread-safe.
  std::vector<dvec3> drawn_positions(const SelectedTile& tile) const;
  /// How far the drawn surface of a selected tile may be from the data, m.
  double error_m(const TileId& tile) const { return builder_.make_meta(tile).error_m; }

  struct Stats {
    uint32_t tiles_drawn = 0, tiles_loaded = 0;  ///< of the last prepare()
    uint32_t tiles_missing = 0;                  ///< covered by coarser ones, or by drafts (LoadedTile)
    uint64_t triangles = 0;
    uint32_t deepest_level = 0;
    double select_ms = 0.0, build_ms = 0.0, upload_ms = 0.0;
    double screen_error_px = 0.0;  ///< larger than asked for when the view did not fit
    uint64_t blocks_read = 0;      ///< raster blocks, since the start
    uint64_t gpu_bytes = 0;
    TileLoader::Stats background;  ///< since the start
  };
  const Stats& stats() const { return stats_; }
  const std::vector<SelectedTile>& selected() const { return selected_; }
  const HeightSampler& heights() const { return ground_; }
  const ImagerySampler& imagery() const { return imagery_; }
  const RasterCaches& caches() const { return caches_; }

 private:
  void select_complete(TerrainView view, const TerrainWait& wait);
  void select_streaming(const TerrainView& view, const TerrainWait& wait);
  void load(const std::vector<TileId>& missing, const TerrainWait& wait);
  void warn_of_error(double screen_error_px);
  /// After a moment without their data; the rest comes later.
  void load_roots();
  /// Uploads a tile, in place of what is there of it.
  void put(const TileId& tile, const LoadedTile& loaded);
  size_t unfinished_in_view() const;
  void start_loader();
  /// Uploads those that are in memory, within the budget of a frame, and asks for the others.
  void fetch(const std::vector<TileId>& wanted);
  /// Index ranges of a tile's visible quarters, neighbouring ones as one.
  template <typename F>
  void for_each_range(const SelectedTile& s, F&& visit) const;

  gpu::Device& device_;
  TerrainParams params_;
  RasterCaches caches_;
  HeightSampler ground_;
  ImagerySampler imagery_;
  TileBuilder builder_;
  TileMetaCache metas_;

  gpu::GraphicsPipeline raster_pipeline_;
  gpu::ComputePipeline classify_pipeline_;
  mutable std::array<gpu::ComputePipeline, 2> resolve_pipelines_;  ///< by day, by night; made when a frame needs them
  TileTopologies topologies_;
  gpu::Buffer indices_;
  gpu::Image night_map_;
  TileAtlas atlas_;
  std::unordered_map<TileId, TileMeta> resident_metas_;  // streaming: of tiles that are or were in the atlas
  enum class Unfinished { blank, draft };                // no data, or not all of it
  std::unordered_map<TileId, Unfinished> unfinished_;    // streaming: tiles in the atlas
  std::vector<TileId> wanted_;                           // streaming: by the last prepare()
  uint64_t uploaded_bytes_ = 0;                          // streaming: in this frame

  std::vector<SelectedTile> selected_;
  double error_scale_ = 1.0;  // streaming: of the screen error, where tiles would not fit
  bool warned_too_many_ = false;
  Stats stats_;
  std::unique_ptr<TileLoader> loader_;  // last: its threads use the builder
};

}  // namespace nepho
