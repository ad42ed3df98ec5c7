#include "terrain/ground_map.h"

#include <chrono>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "base/error.h"
#include "base/give_way.h"
#include "base/parallel.h"
#include "terrain/tile_reads.h"

namespace nepho {

namespace {

bool same(const shared::RegionMap& a, const shared::RegionMap& b) {
  return a.centre == b.centre && a.east == b.east && a.north == b.north && a.half_m == b.half_m &&
         a.radius_m == b.radius_m && a.levels == b.levels;
}

/// Light from clouds takes the ground's means over kilometres.
bool serves(const shared::RegionMap& have, const shared::RegionMap& want) {
  constexpr float kApart = 0.25f;  // of level 0's half side
  constexpr float kStretched = 1.25f;
  const float stretch = have.half_m / want.half_m, apart_m = glm::length(have.centre - want.centre) * want.radius_m;
  return have.levels == want.levels && stretch < kStretched && stretch > 1.0f / kStretched &&
         apart_m <= kApart * want.half_m;
}

}  // namespace

GroundMap::~GroundMap() {
  stop_ = true;
  if (next_.valid()) next_.wait();
}

void GroundMap::update(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map,
                       Follow follow) {
  const bool same_ground = albedo_ && heights_ == &heights && imagery_ == &imagery;
  const bool done = next_.valid() && next_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  if (done && follow == Follow::in_background && same_ground) show(next_.get());
  if (same_ground && (follow == Follow::exactly ? same(map, map_) : serves(map_, map))) return;
  if (same_ground && follow == Follow::in_background) {
    if (next_.valid()) return;
    next_ = std::async(std::launch::async, [this, &heights, &imagery, map] {
      give_way();
      const OneCore one_core;
      const TileReads reads(TileReads::Extent::everything, &stop_);
      return Made{map, sample_ground(heights, imagery, map)};
    });
    return;
  }
  if (next_.valid()) {  // of another ground, or of a place that is left
    stop_ = true;
    next_.wait();
    next_ = {};
    stop_ = false;
  }
  show({map, sample_ground(heights, imagery, map)});
  heights_ = &heights;
  imagery_ = &imagery;
}

void GroundMap::show(const Made& made) {
  const shared::RegionMap& map = made.map;
  if (!albedo_ || map.levels != map_.levels) {
    const Extent3D extent{kTexels, kTexels};
    albedo_ = device_.create_image(
        {.name = "ground.albedo", .extent = extent, .format = Format::rgba16f, .layers = map.levels});
    height_ =
        device_.create_image({.name = "ground.height", .extent = extent, .format = Format::r32f, .layers = map.levels});
  }
  std::vector<uint64_t> halves;
  halves.reserve(made.texels.albedo.size());
  for (const glm::vec4& a : made.texels.albedo) halves.push_back(glm::packHalf4x16(a));
  constexpr size_t kLayer = size_t{kTexels} * kTexels;
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t level = 0; level < map.levels; ++level) {
    uploads.push_back({&albedo_, std::as_bytes(std::span(halves).subspan(level * kLayer, kLayer)), 0, level});
    uploads.push_back(
        {&height_, std::as_bytes(std::span(made.texels.height_m).subspan(level * kLayer, kLayer)), 0, level});
  }
  device_.upload(uploads);
  map_ = map;
}

GroundMap::Refs GroundMap::import_into(FrameGraph& graph) const {
  NEPHO_ASSERT(albedo_);
  return {graph.import(albedo_), graph.import(height_)};
}

}  // namespace nepho
