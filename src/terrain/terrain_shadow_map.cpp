#include "terrain/terrain_shadow_map.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "base/give_way.h"
#include "base/parallel.h"
#include "geo/frames.h"
#include "geo/region_map.h"
#include "gpu/commands.h"
#include "terrain/ground_texels.h"
#include "terrain/terrain_lit.comp.h"
#include "terrain/terrain_volume.comp.h"
#include "terrain/tile_reads.h"

namespace nepho {

namespace {

static_assert(sizeof(shared::TerrainShadowConstants) == sizeof(shared::RegionMap) + 4);

constexpr size_t kSide = shared::kShadowTexels;
constexpr double kFinestHalf_m = 2e3;       ///< of level 0 near the ground
constexpr double kLooksDownFrom_m = 15e3;   ///< cameras above have the map where they look
constexpr double kHighestLight_rad = 1.05;  ///< slopes are hardly ever steeper: 60 degrees
constexpr double kLowestLight_rad = -0.1;   ///< nothing on Earth is lit from so far below the horizon
constexpr float kEven_m = 1.0f;
/// In sequences: a fifth of the sun's radius, far less than a penumbra; and what a cut turns it by.
constexpr double kTurned_rad = 0.9e-3, kTurnedFar_rad = 3e-3;
constexpr double kMoves = 0.25;  ///< of level 0's half side, before the map follows the camera

/// The nested maps that a camera wants: finer the nearer it is to the ground, and as wide as it can see mountains, and
/// as those can be shaded by others.
shared::RegionMap region_for(const FrameInfo& frame, double highest_m) {
  const shared::PlanetView& planet = frame.constants.planet;
  const double a = static_cast<double>(planet.a_m);
  const double height_m = std::max(static_cast<double>(planet.camera_height_m), 0.0);
  const auto dip = [&](double h_m) { return std::acos(a / (a + h_m)); };
  const double top_m = std::max(highest_m, 100.0);
  double reach_m = a * (dip(height_m) + 2.0 * dip(top_m));
  dvec3 centre = frame.camera_ecef_m;
  if (height_m > kLooksDownFrom_m) {
    const vec3 forward = glm::normalize(frame.constants.forward);
    glm::vec2 t;
    if (shared::intersect_shell(planet, forward, 0.0f, t) && t.x > 0.0f) {
      const dvec3 hit = centre + dvec3(forward) * static_cast<double>(t.x);
      reach_m += a * std::acos(std::clamp(glm::dot(glm::normalize(hit), glm::normalize(centre)), -1.0, 1.0));
      centre = hit;
    }
  }
  double half_m = kFinestHalf_m;
  while (half_m < height_m - top_m) half_m *= 2.0;
  uint32_t levels = 1;
  while (half_m * std::exp2(levels - 1) < std::min(reach_m, 1.9 * a)) ++levels;
  return make_region_map(centre, half_m, std::max(levels, 2u));  // an array has two layers at least
}

bool serves(const shared::RegionMap& have, const shared::RegionMap& want) {
  const float apart_m = glm::length(have.centre - want.centre) * want.radius_m;
  return have.half_m == want.half_m && have.levels == want.levels &&
         static_cast<double>(apart_m) <= kMoves * static_cast<double>(want.half_m);
}

}  // namespace

std::vector<float> highest_around(std::vector<float> heights, const std::vector<float>& inside,
                                  std::vector<std::vector<float>>& mips) {
  mips.assign(1, heights);
  std::vector<float> most = std::move(heights);
  if (!inside.empty()) {
    // The finer level is the middle half of this one.
    for (size_t j = 0; j < kSide; ++j)
      for (size_t i = 0; i < kSide; ++i) {
        float& m = most[(j / 2 + kSide / 4) * kSide + i / 2 + kSide / 4];
        m = std::max(m, inside[j * kSide + i]);
      }
  }
  std::vector<float> cells = most;  // highest of each cell alone
  for (size_t side = kSide / 2; mips.size() < shared::kShadowMips; side /= 2) {
    std::vector<float> larger(side * side), around(side * side);
    for (size_t j = 0; j < side; ++j)
      for (size_t i = 0; i < side; ++i) {
        const float* at = &cells[2 * j * 2 * side + 2 * i];
        larger[j * side + i] = std::max({at[0], at[1], at[2 * side], at[2 * side + 1]});
      }
    for (size_t j = 0; j < side; ++j)
      for (size_t i = 0; i < side; ++i) {
        float m = larger[j * side + i];
        for (size_t y = j > 0 ? j - 1 : 0; y <= std::min(j + 1, side - 1); ++y)
          for (size_t x = i > 0 ? i - 1 : 0; x <= std::min(i + 1, side - 1); ++x) m = std::max(m, larger[y * side + x]);
        around[j * side + i] = m;
      }
    cells = std::move(larger);
    mips.push_back(std::move(around));
  }
  return most;
}

TerrainShadowMap::Made TerrainShadowMap::make(const HeightSampler& heights, const shared::RegionMap& map) {
  const std::vector<float> all = sample_ground_crests(heights, map, shared::kShadowTexels);
  Made made{.map = map, .mips = std::vector<std::vector<std::vector<float>>>(map.levels)};
  std::vector<float> inside;
  for (uint32_t level = 0; level < map.levels; ++level) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(level * kSide * kSide);
    inside = highest_around({first, first + static_cast<std::ptrdiff_t>(kSide * kSide)}, inside, made.mips[level]);
  }
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  made.lowest_m = *low;
  made.highest_m = *high;
  return made;
}

TerrainShadowMap::~TerrainShadowMap() {
  stop_ = true;
  if (next_.valid()) next_.wait();
}

void TerrainShadowMap::show(const Made& made) {
  const shared::RegionMap& map = made.map;
  if (!image_ || map.levels != constants_.map.levels)
    image_ = device_.create_image({.name = "terrain.shadow_heights",
                                   .extent = {kSide, kSide},
                                   .format = Format::r32f,
                                   .mip_levels = shared::kShadowMips,
                                   .layers = map.levels});
  for (uint32_t level = 0; level < map.levels; ++level) {
    std::vector<gpu::ImageUpload> uploads;
    for (uint32_t mip = 0; mip < shared::kShadowMips; ++mip)
      uploads.push_back({&image_, std::as_bytes(std::span(made.mips[level][mip])), mip, level});
    device_.upload(uploads);
  }
  constants_ = {.map = map, .highest_m = made.highest_m};
  lowest_m_ = made.lowest_m;
  volume_lights_.clear();
}

void TerrainShadowMap::update(const HeightSampler& heights, const shared::RegionMap& map) {
  show(make(heights, map));
  heights_ = &heights;
}

bool TerrainShadowMap::update(const HeightSampler& heights, const FrameInfo& frame, bool in_background) {
  const shared::FrameConstants& c = frame.constants;
  if (static_cast<double>(c.planet.camera_height_m) < kLooksDownFrom_m) {
    const double light_rad = std::asin(std::clamp(static_cast<double>(glm::dot(c.camera_up, c.key_dir)), -1.0, 1.0));
    if (light_rad > kHighestLight_rad || light_rad < kLowestLight_rad) return false;
  }
  if (heights.highest_land_m() - heights.deepest_land_m() <= static_cast<double>(kEven_m)) return false;
  const shared::RegionMap map = region_for(frame, heights.highest_land_m());
  if (next_.valid() && next_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    show(next_.get());
    draft_ = false;
  }
  const bool serves_view = !draft_ && serves(constants_.map, map);
  if (!image_ || heights_ != &heights || (!in_background && !serves_view)) {
    // The first picture does not wait for a large raster to be read whole.
    const TileReads reads(in_background ? TileReads::Extent::draft : TileReads::Extent::everything);
    update(heights, map);
    draft_ = reads.left_out() > 0;
  } else if (!serves_view && !next_.valid()) {
    next_ = std::async(std::launch::async, [this, &heights, map] {
      give_way();
      const OneCore one_core;
      const TileReads reads(TileReads::Extent::everything, &stop_);
      return make(heights, map);
    });
  }
  return constants_.highest_m - lowest_m_ > kEven_m;
}

TerrainShadowMap::Refs TerrainShadowMap::import_into(FrameGraph& graph) const {
  NEPHO_ASSERT(image_);
  return {graph.import(image_), graph.constants("terrain.shadow", constants_)};
}

double TerrainShadowMap::shade_top_m(const FrameInfo& frame) const {
  const shared::FrameConstants& c = frame.constants;
  // Light that comes from below the horizon leaves shadows that climb as the planet curves away under them.
  const double below_rad =
      std::max(std::asin(std::clamp(-static_cast<double>(glm::dot(c.camera_up, c.key_dir)), -1.0, 1.0)), 0.0);
  return static_cast<double>(constants_.highest_m) +
         0.5 * static_cast<double>(c.planet.a_m) * std::min(below_rad * below_rad, 0.01);
}

TerrainVolumeRefs TerrainShadowMap::add_volume(FrameGraph& graph, const FrameInfo& frame, bool sequence) {
  NEPHO_ASSERT(image_);
  const uint32_t levels = constants_.map.levels;
  if (!volume_ || volume_.desc().layers != levels) {
    volume_ = device_.create_image({.name = "terrain.volume",
                                    .extent = {shared::kShadowTexels, shared::kShadowTexels},
                                    .format = Format::rgba32f,
                                    .layers = levels});
    lit_ = device_.create_image({.name = "terrain.lit",
                                 .extent = {shared::kShadowTexels, shared::kShadowTexels},
                                 .format = Format::r32f,
                                 .layers = levels});
    volume_lights_.clear();
  }
  const TerrainVolumeRefs refs{graph.import(volume_), graph.constants("terrain.volume_map", constants_.map),
                               graph.import(lit_)};
  const glm::vec3 light = frame.constants.key_dir;
  volume_lights_.resize(levels, glm::vec3(0.0f));  // of none
  uint32_t first = 0, count = levels;
  double turned = 0.0;  // the most of a level's light, rad
  for (uint32_t level = 0; level < levels; ++level) {
    const double by = static_cast<double>(glm::length(light - volume_lights_[level]));
    if (by <= turned) continue;
    turned = by;
    first = level;
  }
  const bool one_by_one = sequence && turned < kTurnedFar_rad;
  if (turned <= (one_by_one ? kTurned_rad : 0.0)) return refs;
  if (one_by_one)
    count = 1;
  else
    first = 0;
  std::fill_n(volume_lights_.begin() + first, count, light);
  if (!bake_) bake_ = gpu::ComputePipeline(device_, {.name = "terrain.volume", .spirv = terrain_volume_comp});
  auto bake = graph.pass("terrain.volume");
  bake.uniform("frame", frame.buffer).read_write("out_volume", refs.shadow).effect();
  bind_terrain_shadow(bake, import_into(graph));
  bake.record([this, first, count](gpu::Commands& cmd) {
    cmd.bind(bake_).push(first).dispatch_threads(shared::kShadowTexels, shared::kShadowTexels, count);
  });
  if (!bake_lit_) bake_lit_ = gpu::ComputePipeline(device_, {.name = "terrain.lit", .spirv = terrain_lit_comp});
  auto lit = graph.pass("terrain.lit");
  lit.uniform("frame", frame.buffer)
      .sample("volume_tex", refs.shadow, Sampler::nearest_clamp)
      .read_write("out_lit", refs.lit)
      .effect();
  bind_terrain_shadow(lit, import_into(graph));
  lit.record([this, first, count](gpu::Commands& cmd) {
    cmd.bind(bake_lit_).push(first).dispatch_threads(shared::kShadowTexels, shared::kShadowTexels, count);
  });
  return refs;
}

void bind_terrain_shadow(FrameGraph::PassBuilder& pass, const TerrainShadowMap::Refs& refs) {
  pass.sample("terrain_shadow_tex", refs.heights).uniform("terrain_shadow", refs.constants);
}

}  // namespace nepho
