#include "terrain/terrain.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/log.h"
#include "base/parallel.h"
#include "common/pixel_tiles.h"
#include "gpu/commands.h"
#include "terrain/terrain.frag.h"
#include "terrain/terrain.vert.h"
#include "terrain/terrain_classify.comp.h"
#include "terrain/terrain_resolve.comp.h"
#include "terrain/terrain_shared.h"

namespace nepho {

static_assert(sizeof(shared::TerrainTile) == 32);
static_assert(sizeof(shared::TerrainRasterPush) == 24);

namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180.0;
constexpr uint32_t kFirstSlots = 256;
/// Vertices stay below 128 MiB, the largest storage buffer that every device has.
constexpr uint32_t kMostSlots = 1024;
constexpr size_t kTilesPerUpload = 64;
constexpr uint32_t kNightWidth = 2048;

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

TerrainView view_of(const FrameInfo& frame, const TerrainParams& params, double deepest_land_m) {
  const shared::FrameConstants& c = frame.constants;
  TerrainView view;
  view.camera_ecef_m = frame.camera_ecef_m;
  view.forward = glm::normalize(dvec3(c.forward));
  view.right = dvec3(c.right);
  view.up = dvec3(c.up);
  view.pixel_angle_rad = static_cast<double>(c.pixel_angle_rad);
  view.screen_error_px = params.screen_error_px;
  view.deepest_land_m = deepest_land_m;
  return view;
}

uint32_t tiles_along(uint32_t pixels) { return (pixels + shared::kPixelTile - 1) / shared::kPixelTile; }

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
      caches_(make_raster_caches(params)),
      ground_(std::move(sources.elevation), sources.has_default, std::move(sources.geoid), caches_),
      imagery_(std::move(sources.imagery), ground_, sources.bare_albedo, caches_),
      builder_(ground_, imagery_, Ellipsoid::wgs84()),
      metas_(builder_) {
  if (sources.water_mask) ground_.set_water_mask(std::move(sources.water_mask));
  raster_pipeline_ = gpu::GraphicsPipeline(device_, {.name = "terrain.raster",
                                                     .vertex_spirv = terrain_vert,
                                                     .fragment_spirv = terrain_frag,
                                                     .color_formats = {Format::rg32u}});
  classify_pipeline_ = gpu::ComputePipeline(device_, {.name = "terrain.classify", .spirv = terrain_classify_comp});
  resolve_pipeline_ = gpu::ComputePipeline(device_, {.name = "terrain.resolve", .spirv = terrain_resolve_comp});
  topologies_ = make_topologies();
  indices_ =
      device_.create_buffer({.name = "terrain.indices", .size_bytes = topologies_.indices.size() * sizeof(uint32_t)});
  const gpu::BufferUpload upload{&indices_, 0, bytes_of(topologies_.indices)};
  device_.upload({}, std::span(&upload, 1));
  make_atlases(kFirstSlots);
  load_night_lights(sources.night_lights);
}

Terrain::~Terrain() = default;

double Terrain::ground_height_m(double lat_rad, double lon_rad) const {
  return ground_.height_m(lat_rad, lon_rad, kMaxTileLevel);
}

void Terrain::make_atlases(uint32_t slots) {
  slots_.assign(slots, {});
  slot_of_.clear();
  // The old ones go first: both together may not fit.
  imagery_atlas_ = {};
  slope_atlas_ = {};
  vertices_ = {};
  imagery_atlas_ = device_.create_image({.name = "terrain.imagery",
                                         .extent = {shared::kTerrainImageryTexels, shared::kTerrainImageryTexels},
                                         .format = Format::rgba8_srgb,
                                         .mip_levels = shared::kTerrainImageryMips,
                                         .layers = slots});
  slope_atlas_ = device_.create_image({.name = "terrain.slopes",
                                       .extent = {shared::kTerrainSlopeTexels, shared::kTerrainSlopeTexels},
                                       .format = Format::rg16f,
                                       .mip_levels = shared::kTerrainSlopeMips,
                                       .layers = slots});
  vertices_ = device_.create_buffer(
      {.name = "terrain.vertices", .size_bytes = uint64_t{slots} * kTileVertices * sizeof(SplitVertex)});
  stats_.gpu_bytes = imagery_atlas_.size_bytes() + slope_atlas_.size_bytes() + vertices_.desc().size_bytes;
}

void Terrain::load_night_lights(const std::shared_ptr<Raster>& raster) {
  const uint32_t width = raster ? kNightWidth : 1, height = std::max(1u, width / 2);
  const Extent3D extent{width, height};
  std::vector<float> rgbx(size_t{width} * height * 4, 0.0f);
  if (raster) {
    const BlockCache blocks(raster, caches_);
    std::vector<double> lon(width);
    for (uint32_t i = 0; i < width; ++i) lon[i] = -180.0 + 360.0 * (i + 0.5) / width;
    const uint32_t k = blocks.reduction_for(360.0 / width);
    parallel_for(height, [&](size_t j) {
      const double lat[] = {90.0 - 180.0 * (static_cast<double>(j) + 0.5) / height};
      lay_over(blocks, k, lat, lon, &rgbx[j * width * 4]);
    });
  }
  std::vector<std::vector<uint8_t>> mips(1);
  for (const float v : rgbx) mips[0].push_back(static_cast<uint8_t>(std::clamp(v, 0.0f, 255.0f) + 0.5f));
  uint32_t w = width, h = height;
  while (w > 1 && h > 1) {
    const std::vector<uint8_t>& from = mips.back();
    std::vector<uint8_t> to(size_t{w / 2} * (h / 2) * 4);
    for (size_t j = 0; j < h / 2; ++j)
      for (size_t i = 0; i < w / 2 * 4; ++i) {
        const size_t at = 2 * j * w * 4 + (i / 4) * 8 + i % 4;
        to[j * (w / 2) * 4 + i] =
            static_cast<uint8_t>((from[at] + from[at + 4] + from[at + w * 4] + from[at + w * 4 + 4] + 2) / 4);
      }
    mips.push_back(std::move(to));
    w /= 2;
    h /= 2;
  }
  const auto levels = static_cast<uint32_t>(mips.size());
  night_map_ = device_.create_image(
      {.name = "terrain.night_lights", .extent = extent, .format = Format::rgba8_srgb, .mip_levels = levels});
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t m = 0; m < levels; ++m) uploads.push_back({&night_map_, bytes_of(mips[m]), m, 0});
  device_.upload(uploads);
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

void Terrain::prepare(const FrameInfo& frame) {
  ++frame_;
  auto start = std::chrono::steady_clock::now();
  TerrainView view = view_of(frame, params_, ground_.deepest_land_m());
  selected_ = select_tiles(view, metas_);
  while (selected_.size() > kMostSlots) {
    view.screen_error_px *= 1.25;
    selected_ = select_tiles(view, metas_);
  }
  if (view.screen_error_px > params_.screen_error_px && !warned_too_many_) {
    warned_too_many_ = true;
    log_warning("terrain: this view needs more than {} tiles; drawn with an error of {:.2f} px instead of {:.2f}",
                kMostSlots, view.screen_error_px, params_.screen_error_px);
  }
  stats_.select_ms = ms_since(start);
  stats_.build_ms = stats_.upload_ms = 0.0;
  stats_.screen_error_px = view.screen_error_px;

  if (selected_.size() > slots_.size()) {
    auto slots = static_cast<uint32_t>(slots_.size());
    while (slots < selected_.size()) slots *= 2;
    make_atlases(slots);
  }
  std::vector<TileId> missing;
  for (const SelectedTile& s : selected_) {
    const auto found = slot_of_.find(s.tile);
    if (found != slot_of_.end())
      slots_[found->second].last_frame = frame_;
    else
      missing.push_back(s.tile);
  }
  load(missing);

  stats_.tiles_drawn = static_cast<uint32_t>(selected_.size());
  stats_.tiles_loaded = static_cast<uint32_t>(missing.size());
  stats_.triangles = 0;
  stats_.deepest_level = 0;
  for (const SelectedTile& s : selected_) {
    for_each_range(s, [&](TileTopologies::Range range) { stats_.triangles += range.count / 3; });
    stats_.deepest_level = std::max(stats_.deepest_level, s.tile.level);
  }
  stats_.blocks_read = ground_.blocks_read() + imagery_.blocks_read();
}

uint32_t Terrain::take_slot(const TileId& tile) {
  // The one that was drawn longest ago; those of this frame are never taken, there are enough slots for them all.
  const auto oldest = std::min_element(slots_.begin(), slots_.end(), [](const Slot& a, const Slot& b) {
    return (a.used ? a.last_frame : 0) < (b.used ? b.last_frame : 0);
  });
  NEPHO_ASSERT(!oldest->used || oldest->last_frame < frame_);
  if (oldest->used) slot_of_.erase(oldest->tile);
  *oldest = {tile, true, frame_};
  const auto index = static_cast<uint32_t>(oldest - slots_.begin());
  slot_of_[tile] = index;
  return index;
}

void Terrain::load(const std::vector<TileId>& missing) {
  for (size_t first = 0; first < missing.size(); first += kTilesPerUpload) {
    auto start = std::chrono::steady_clock::now();
    const size_t count = std::min(kTilesPerUpload, missing.size() - first);
    std::vector<TileData> made(count);
    parallel_for(count, [&](size_t i) { made[i] = builder_.make_data(missing[first + i]); });
    stats_.build_ms += ms_since(start);
    start = std::chrono::steady_clock::now();
    std::vector<gpu::ImageUpload> images;
    std::vector<gpu::BufferUpload> buffers;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t slot = take_slot(missing[first + i]);
      for (uint32_t m = 0; m < made[i].imagery.size(); ++m)
        images.push_back({&imagery_atlas_, bytes_of(made[i].imagery[m]), m, slot});
      for (uint32_t m = 0; m < made[i].slopes.size(); ++m)
        images.push_back({&slope_atlas_, bytes_of(made[i].slopes[m]), m, slot});
      buffers.push_back({&vertices_, uint64_t{slot} * kTileVertices * sizeof(SplitVertex), bytes_of(made[i].vertices)});
    }
    device_.upload(images, buffers);
    stats_.upload_ms += ms_since(start);
  }
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
    t.slot = slot_of_.at(s.tile);
    t.edges = s.edges;
    t.texel_m = static_cast<float>(imagery_texel_deg(s.tile.level) * kMetresPerDegree);
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
  const Outputs out{.depth_m = graph.create("terrain.depth_m", {.extent = frame.extent, .format = Format::r32f}),
                    .albedo = graph.create("terrain.albedo", {.extent = frame.extent, .format = Format::rgba16f}),
                    .normal = graph.create("terrain.normal", {.extent = frame.extent, .format = Format::rgba16f}),
                    .emission = graph.create("terrain.emission", {.extent = frame.extent, .format = Format::rgba16f}),
                    .surface_tiles = no_pixel_tiles(graph, "terrain.surface_tiles", frame.extent),
                    .sky_tiles = no_pixel_tiles(graph, "terrain.sky_tiles", frame.extent)};
  const SplitVertex camera = split(frame.camera_ecef_m);
  graph.pass("terrain.raster")
      .color(id)
      .depth(depth, 0.0f)
      .uniform("frame", frame.buffer)
      .read("vertices", graph.import(vertices_))
      .read("tiles", tile_buffer)
      .index_buffer(graph.import(indices_))
      .record([this, draws, push = shared::TerrainRasterPush{camera.hi, camera.lo}](gpu::Commands& cmd) {
        cmd.bind(raster_pipeline_).push(push);
        for (const Draw& d : draws) cmd.draw_indexed(d.range.count, d.range.first, 1, d.tile);
      });
  graph.pass("terrain.classify")
      .sample("depth_tex", depth, Sampler::nearest_clamp)
      .read_write("surface_tiles", out.surface_tiles)
      .read_write("sky_tiles", out.sky_tiles)
      .fill("depth_m", out.depth_m)
      .fill("albedo", out.albedo)
      .record([this, extent = frame.extent](gpu::Commands& cmd) {
        // What sky tiles hold; the others get theirs from terrain.resolve.
        cmd.fill("depth_m", shared::kFarDepth_m).fill("albedo", 0.0f);
        cmd.bind(classify_pipeline_).dispatch_threads(tiles_along(extent.width), tiles_along(extent.height));
      });
  graph.pass("terrain.resolve")
      .uniform("frame", frame.buffer)
      .read("tiles", tile_buffer)
      .sample("depth_tex", depth, Sampler::nearest_clamp)
      .sample("id_tex", id, Sampler::nearest_clamp)
      .sample("imagery_tex", graph.import(imagery_atlas_))
      .sample("slope_tex", graph.import(slope_atlas_))
      .sample("night_tex", graph.import(night_map_), Sampler::linear_repeat_u)
      .write("out_depth_m", out.depth_m)
      .write("out_albedo", out.albedo)
      .write("out_normal", out.normal)
      .write("out_emission", out.emission)
      .read("pixel_tiles", out.surface_tiles)
      .indirect(out.surface_tiles)
      .record([this](gpu::Commands& cmd) { cmd.bind(resolve_pipeline_).dispatch_indirect(); });
  return out;
}

}  // namespace nepho
