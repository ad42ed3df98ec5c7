#include "terrain/ground_map.h"

#include <glm/gtc/packing.hpp>

#include "base/error.h"

namespace nepho {

namespace {

bool same(const shared::RegionMap& a, const shared::RegionMap& b) {
  return a.centre == b.centre && a.east == b.east && a.north == b.north && a.half_m == b.half_m &&
         a.radius_m == b.radius_m && a.levels == b.levels;
}

}  // namespace

void GroundMap::update(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map) {
  if (albedo_ && heights_ == &heights && imagery_ == &imagery && same(map, map_)) return;
  const GroundTexels texels = sample_ground(heights, imagery, map);
  if (!albedo_ || map.levels != map_.levels) {
    const Extent3D extent{kTexels, kTexels};
    albedo_ = device_.create_image(
        {.name = "ground.albedo", .extent = extent, .format = Format::rgba16f, .layers = map.levels});
    height_ =
        device_.create_image({.name = "ground.height", .extent = extent, .format = Format::r32f, .layers = map.levels});
  }
  std::vector<uint64_t> halves;
  halves.reserve(texels.albedo.size());
  for (const glm::vec4& a : texels.albedo) halves.push_back(glm::packHalf4x16(a));
  constexpr size_t kLayer = size_t{kTexels} * kTexels;
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t level = 0; level < map.levels; ++level) {
    uploads.push_back({&albedo_, std::as_bytes(std::span(halves).subspan(level * kLayer, kLayer)), 0, level});
    uploads.push_back({&height_, std::as_bytes(std::span(texels.height_m).subspan(level * kLayer, kLayer)), 0, level});
  }
  device_.upload(uploads);
  map_ = map;
  heights_ = &heights;
  imagery_ = &imagery;
}

GroundMap::Refs GroundMap::import_into(FrameGraph& graph) const {
  NEPHO_ASSERT(albedo_);
  return {graph.import(albedo_), graph.import(height_)};
}

}  // namespace nepho
