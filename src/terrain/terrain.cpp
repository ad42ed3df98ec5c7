#include "terrain/terrain.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/log.h"
#include "base/parallel.h"
#include "common/pixel_tiles.h"
#include "gpu/commands.h"
#include "terrain/night_lights.h"
#include "terrain/terrain.frag.h"
#include "terrain/terrain.vert.h"
#include "terrain/terrain_classify.comp.h"
#include "terrain/terrain_classify_group.comp.h"
#include "terrain/terrain_resolve.comp.h"
#include "terrain/terrain_shared.h"
#include "terrain/terrain_view.h"

namespace nepho {

static_assert(sizeof(shared::TerrainTile) == 92);
static_assert(sizeof(shared::TerrainRasterPush) == 24);

namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180.0;
constexpr uint32_t kFirstSlots = 256;
/// A small picture of a rough place needs about this many.
constexpr uint32_t kFewestSlots = 96;
constexpr size_t kTilesPerUpload = 64;
/// Some 300 bytes each.
constexpr size_t kMostMetas = 100'000;

uint32_t slots_within(uint32_t budget_mb) {
  const uint64_t slots = (uint64_t{budget_mb} << 20) / TileAtlas::slot_bytes();
  return static_cast<uint32_t>(std::clamp<uint64_t>(slots, kFewestSlots, TileAtlas::kMostSlots));
}

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

uint32_t tiles_along(uint32_t pixels) { return (pixels + shared::kPixelTile - 1) / shared::kPixelTile; }

/// Whether lights of cities may be on somewhere in view (terrain_resolve.comp: the sun is less than 6 degrees up).
bool sees_night(const shared::FrameConstants& frame) {
  // The ellipsoid's verticals turn a little faster than a sphere's.
  constexpr double kHighestGround_m = 9e3, kOn_rad = 0.106, kVerticals_rad = 0.01;
  const double a_m = static_cast<double>(frame.planet.a_m), h_m = static_cast<double>(frame.planet.camera_height_m);
  const auto dip = [&](double height_m) { return std::acos(a_m / (a_m + std::max(height_m, 0.0))); };
  const double sine = std::clamp(static_cast<double>(glm::dot(frame.camera_up, frame.sun_dir)), -1.0, 1.0);
  return std::asin(sine) - dip(h_m) - dip(kHighestGround_m) < kOn_rad + kVerticals_rad;
}

/// An empty list with room for every tile of the picture.
BufferRef no_pixel_tiles(FrameGraph& graph, const std::string& name, Extent2D extent) {
  std::vector<uint32_t> list(4 + size_t{tiles_along(extent.width)} * tiles_along(extent.height), 0u);
  list[1] = list[2] = 1u;
  return graph.constants(name, list);
}

template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& v) {
  return std::as_bytes(std::span(v));
}

}  // namespace

Terrain::Terrain(gpu::Device& device, TerrainSources sources, const TerrainParams& params)
    : device_(device),
      params_(params),
      caches_(sources.caches.memory ? sources.caches : make_raster_caches(params)),
      ground_(std::move(sources.elevation), sources.has_default, std::move(sources.geoid), caches_),
      imagery_(std::move(sources.imagery), ground_, sources.bare_albedo, caches_),
      builder_(ground_, imagery_, Ellipsoid::wgs84()),
      metas_(builder_),
      atlas_(device, kFirstSlots, slots_within(params.gpu_budget_mb)) {
  if (sources.water_mask) ground_.set_water_mask(std::move(sources.water_mask));
  raster_pipeline_ = gpu::GraphicsPipeline(device_, {.name = "terrain.raster",
                                                     .vertex_spirv = terrain_vert,
                                                     .fragment_spirv = terrain_frag,
                                                     .color_formats = {Format::rg32u}});
  if (device_.info().is_software)
    classify_pipeline_ = gpu::ComputePipeline(device_, {.name = "terrain.classify", .spirv = terrain_classify_comp});
  else
    classify_pipeline_ =
        gpu::ComputePipeline(device_, {.name = "terrain.classify", .spirv = terrain_classify_group_comp});
  topologies_ = make_topologies();
  indices_ =
      device_.create_buffer({.name = "terrain.indices", .size_bytes = topologies_.indices.size() * sizeof(uint32_t)});
  const gpu::BufferUpload upload{&indices_, 0, bytes_of(topologies_.indices)};
  device_.upload({}, std::span(&upload, 1));
  night_map_ = make_night_lights(device_, sources.night_lights, caches_);
}

Terrain::~Terrain() = default;

double Terrain::ground_height_m(double lat_rad, double lon_rad) const {
  return ground_.height_m(lat_rad, lon_rad, kMaxTileLevel);
}

std::vector<dvec3> Terrain::drawn_positions(const SelectedTile& tile) const {
  return nepho::drawn_positions(tile, tile_vertices(tile.tile, ground_, Ellipsoid::wgs84()));
}

template <typename F>
void Terrain::for_each_range(const SelectedTile& s, F&& visit) const {
  TileTopologies::Range joined{0, 0};
  for (uint32_t q = 0; q < 4; ++q) {
    const TileTopologies::Range r = topologies_.quarters[s.edges & 15u][q];
    if (!(s.quarters & (1u << q))) continue;
    if (joined.count > 0 && joined.first + joined.count == r.first) {
      joined.count += r.count;
      continue;
    }
    if (joined.count > 0) visit(joined);
    joined = r;
  }
  if (joined.count > 0) visit(joined);
}

void Terrain::prepare(const FrameInfo& frame, const TerrainWait& wait) {
  atlas_.begin_frame();
  uploaded_bytes_ = 0;
  stats_.build_ms = stats_.upload_ms = stats_.select_ms = 0.0;
  stats_.tiles_loaded = stats_.tiles_missing = 0;
  const TerrainView view = view_of(frame, params_, ground_.deepest_land_m());
  if (wait.complete)
    select_complete(view, wait);
  else
    select_streaming(view, wait);

  stats_.tiles_drawn = static_cast<uint32_t>(selected_.size());
  stats_.triangles = 0;
  stats_.deepest_level = 0;
  for (const SelectedTile& s : selected_) {
    for_each_range(s, [&](TileTopologies::Range range) { stats_.triangles += range.count / 3; });
    stats_.deepest_level = std::max(stats_.deepest_level, s.tile.level);
  }
  stats_.blocks_read = ground_.blocks_read() + imagery_.blocks_read();
  stats_.gpu_bytes = atlas_.bytes();
  if (loader_) stats_.background = loader_->stats();
}

void Terrain::select_complete(TerrainView view, const TerrainWait& wait) {
  const auto start = std::chrono::steady_clock::now();
  if (metas_.size() > kMostMetas) metas_.clear();
  selected_ = select_tiles(view, metas_);
  while (selected_.size() > atlas_.most_slots()) {
    view.screen_error_px *= 1.25;
    selected_ = select_tiles(view, metas_);
  }
  warn_of_error(view.screen_error_px);
  stats_.select_ms = ms_since(start);

  atlas_.grow(static_cast<uint32_t>(selected_.size()));
  std::vector<TileId> missing;
  for (const SelectedTile& s : selected_)
    if (!atlas_.find(s.tile) || unfinished_.contains(s.tile)) missing.push_back(s.tile);
  for (const TileId& tile : missing) unfinished_.erase(tile);
  load(missing, wait);
  stats_.tiles_loaded = static_cast<uint32_t>(missing.size());
}

void Terrain::warn_of_error(double screen_error_px) {
  stats_.screen_error_px = screen_error_px;
  if (screen_error_px <= params_.screen_error_px || warned_too_many_) return;
  warned_too_many_ = true;
  log_warning("terrain: this view needs more than {} tiles; drawn with an error of {:.2f} px instead of {:.2f}",
              atlas_.most_slots(), screen_error_px, params_.screen_error_px);
}

void Terrain::load(const std::vector<TileId>& missing, const TerrainWait& wait) {
  for (size_t first = 0; first < missing.size(); first += kTilesPerUpload) {
    if (wait.on_progress) wait.on_progress(first, missing.size());
    auto start = std::chrono::steady_clock::now();
    const size_t count = std::min(kTilesPerUpload, missing.size() - first);
    std::vector<TileData> made(count);
    parallel_for(count, [&](size_t i) { made[i] = builder_.make_data(missing[first + i]); });
    stats_.build_ms += ms_since(start);
    start = std::chrono::steady_clock::now();
    std::vector<TileAtlas::Upload> uploads;
    for (size_t i = 0; i < count; ++i) uploads.push_back({missing[first + i], &made[i]});
    atlas_.upload(uploads);
    stats_.upload_ms += ms_since(start);
  }
  if (wait.on_progress && !missing.empty()) wait.on_progress(missing.size(), missing.size());
}

Terrain::Outputs Terrain::add(FrameGraph& graph, const FrameInfo& frame) const {
  std::vector<shared::TerrainTile> tiles;
  struct Draw {
    TileTopologies::Range range;
    uint32_t tile;
  };
  std::vector<Draw> draws;
  for (const SelectedTile& s : selected_) {
    const TileBounds b = tile_bounds(s.tile);
    shared::TerrainTile t{};
    t.slot = *atlas_.peek(s.tile);
    t.edges = s.edges;
    t.morph = s.morph;
    t.edge_morph = glm::vec4(s.edge_morph[0], s.edge_morph[1], s.edge_morph[2], s.edge_morph[3]);
    t.corner_morph = glm::vec4(s.corner_morph[0], s.corner_morph[1], s.corner_morph[2], s.corner_morph[3]);
    const ImageryGrid texels = builder_.grid_of_imagery(s.tile);
    const double texel_deg = std::sqrt(texels.lon_step_deg * texels.lat_step_deg),
                 size_deg = tile_size_deg(s.tile.level);
    const glm::dvec2 whole_deg =
        double{shared::kTerrainImageryTexels} * glm::dvec2(texels.lon_step_deg, texels.lat_step_deg);
    t.texel_m = static_cast<float>(texel_deg * kMetresPerDegree);
    t.slope_lod = static_cast<float>(std::log2(texel_deg / slope_texel_deg(s.tile.level)));
    t.detail_log2 = static_cast<float>(texels.detail_log2);
    t.parts = texels.parts ? 1.0f : 0.0f;
    t.atlas_origin =
        glm::vec2((b.west_deg - texels.west_deg) / whole_deg.x, (texels.north_deg - b.north_deg) / whole_deg.y);
    t.atlas_size = glm::vec2(size_deg / whole_deg.x, size_deg / whole_deg.y);
    t.map_origin = glm::vec2((b.west_deg + 180.0) / 360.0, (90.0 - b.north_deg) / 180.0);
    t.map_size = glm::vec2(tile_size_deg(s.tile.level) / 360.0, tile_size_deg(s.tile.level) / 180.0);
    tiles.push_back(t);
    const auto index = static_cast<uint32_t>(tiles.size() - 1);
    for_each_range(s, [&](TileTopologies::Range range) { draws.push_back({range, index}); });
  }
  if (tiles.empty()) tiles.emplace_back();  // buffers are never empty
  const BufferRef tile_buffer = graph.constants("terrain.tiles", tiles);
  const ImageRef depth = graph.create("terrain.depth", {.extent = frame.extent, .format = Format::d32f});
  const ImageRef id = graph.create("terrain.id", {.extent = frame.extent, .format = Format::rg32u});
  const bool night = sees_night(frame.constants);
  // By day it is bound, never written.
  const ImageRef emission = graph.create(
      "terrain.emission", {.extent = night ? Extent3D(frame.extent) : Extent3D{1, 1}, .format = Format::rgba16f});
  const Outputs out{.depth_m = graph.create("terrain.depth_m", {.extent = frame.extent, .format = Format::r32f}),
                    .albedo = graph.create("terrain.albedo", {.extent = frame.extent, .format = Format::rgba16f}),
                    .normal = graph.create("terrain.normal", {.extent = frame.extent, .format = Format::rgba16f}),
                    .emission = night ? emission : ImageRef{},
                    .surface_tiles = no_pixel_tiles(graph, "terrain.surface_tiles", frame.extent),
                    .sky_tiles = no_pixel_tiles(graph, "terrain.sky_tiles", frame.extent)};
  const SplitVertex camera = split(frame.camera_ecef_m);
  graph.pass("terrain.raster")
      .color(id)
      .depth(depth, 0.0f)
      .uniform("frame", frame.buffer)
      .read("vertices", graph.import(atlas_.vertices()))
      .read("tiles", tile_buffer)
      .index_buffer(graph.import(indices_))
      .record([this, draws, push = shared::TerrainRasterPush{camera.hi, camera.lo}](gpu::Commands& cmd) {
        cmd.bind(raster_pipeline_).push(push);
        for (const Draw& d : draws) cmd.draw_indexed(d.range.count, d.range.first, 1, d.tile);
      });
  auto classify = graph.pass("terrain.classify");
  classify.sample("depth_tex", depth, Sampler::nearest_clamp)
      .read_write("surface_tiles", out.surface_tiles)
      .read_write("sky_tiles", out.sky_tiles);
  // What sky tiles hold; the others get theirs from terrain.resolve.
  if (device_.info().is_software)
    classify.fill("depth_m", out.depth_m)
        .fill("albedo", out.albedo)
        .record([this, extent = frame.extent](gpu::Commands& cmd) {
          cmd.fill("depth_m", shared::kFarDepth_m).fill("albedo", 0.0f);
          cmd.bind(classify_pipeline_).dispatch_threads(tiles_along(extent.width), tiles_along(extent.height));
        });
  else
    classify.write("out_depth_m", out.depth_m)
        .write("out_albedo", out.albedo)
        .record([this, extent = frame.extent](gpu::Commands& cmd) {
          cmd.bind(classify_pipeline_).dispatch_threads(8 * tiles_along(extent.width), 8 * tiles_along(extent.height));
        });
  gpu::ComputePipeline& resolve = resolve_pipelines_[night];
  if (!resolve)
    resolve = gpu::ComputePipeline(
        device_, {.name = "terrain.resolve", .spirv = terrain_resolve_comp, .constants = {night ? 1u : 0u}});
  graph.pass("terrain.resolve")
      .uniform("frame", frame.buffer)
      .read("tiles", tile_buffer)
      .sample("depth_tex", depth, Sampler::nearest_clamp)
      .sample("id_tex", id, Sampler::nearest_clamp)
      .sample("imagery_tex", graph.import(atlas_.imagery()))
      .sample("slope_tex", graph.import(atlas_.slopes()))
      .sample("night_tex", graph.import(night_map_), Sampler::linear_repeat_u)
      .write("out_depth_m", out.depth_m)
      .write("out_albedo", out.albedo)
      .write("out_normal", out.normal)
      .write("out_emission", emission)
      .read("pixel_tiles", out.surface_tiles)
      .indirect(out.surface_tiles)
      .record([&resolve](gpu::Commands& cmd) { cmd.bind(resolve).dispatch_indirect(); });
  return out;
}

}  // namespace nepho
