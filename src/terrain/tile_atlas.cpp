#include "terrain/tile_atlas.h"

#include <algorithm>

#include "base/error.h"
#include "terrain/terrain_shared.h"

namespace nepho {

namespace {

uint64_t mip_chain_bytes(uint32_t side, uint32_t mips) {
  uint64_t bytes = 0;
  for (uint32_t m = 0; m < mips; ++m) bytes += uint64_t{side >> m} * (side >> m) * 4;
  return bytes;
}

template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& v) {
  return std::as_bytes(std::span(v));
}

}  // namespace

TileAtlas::TileAtlas(gpu::Device& device, uint32_t slots, uint32_t most_slots)
    : device_(device), most_slots_(std::clamp(most_slots, 1u, kMostSlots)) {
  make_images(std::clamp(slots, 1u, most_slots_));
}

uint64_t TileAtlas::slot_bytes() {
  return uint64_t{kTileVertices} * sizeof(TileVertex) +
         mip_chain_bytes(shared::kTerrainImageryTexels, shared::kTerrainImageryMips) +
         mip_chain_bytes(shared::kTerrainSlopeTexels, shared::kTerrainSlopeMips);
}

uint64_t TileAtlas::bytes() const { return imagery_.size_bytes() + slopes_.size_bytes() + vertices_.desc().size_bytes; }

void TileAtlas::make_images(uint32_t slots) {
  slots_.assign(slots, {});
  slot_of_.clear();
  // The old ones go first: both together may not fit.
  imagery_ = {};
  slopes_ = {};
  vertices_ = {};
  imagery_ = device_.create_image({.name = "terrain.imagery",
                                   .extent = {shared::kTerrainImageryTexels, shared::kTerrainImageryTexels},
                                   .format = Format::rgba8,
                                   .mip_levels = shared::kTerrainImageryMips,
                                   .layers = std::max(slots, 2u)});
  slopes_ = device_.create_image({.name = "terrain.slopes",
                                  .extent = {shared::kTerrainSlopeTexels, shared::kTerrainSlopeTexels},
                                  .format = Format::rg16f,
                                  .mip_levels = shared::kTerrainSlopeMips,
                                  .layers = std::max(slots, 2u)});
  vertices_ = device_.create_buffer(
      {.name = "terrain.vertices", .size_bytes = uint64_t{slots} * kTileVertices * sizeof(TileVertex)});
}

void TileAtlas::grow(uint32_t slots) {
  const uint32_t wanted = std::min(slots, most_slots_);
  if (wanted <= slots_.size()) return;
  make_images(std::min(most_slots_, std::max(wanted, 2 * this->slots())));
}

std::optional<uint32_t> TileAtlas::peek(const TileId& tile) const {
  const auto found = slot_of_.find(tile);
  return found == slot_of_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<uint32_t> TileAtlas::find(const TileId& tile) {
  const auto slot = peek(tile);
  if (slot) slots_[*slot].last_frame = frame_;
  return slot;
}

uint64_t TileAtlas::age(const TileId& tile) const {
  const auto slot = peek(tile);
  return slot ? frame_ - slots_[*slot].first_frame : 0;
}

bool TileAtlas::has_room() const {
  return std::any_of(slots_.begin(), slots_.end(), [&](const Slot& s) { return !s.used || s.last_frame < frame_; });
}

uint32_t TileAtlas::take_slot(const TileId& tile) {
  if (const auto slot = find(tile)) return *slot;
  const auto oldest = std::min_element(slots_.begin(), slots_.end(), [](const Slot& a, const Slot& b) {
    return (a.used ? a.last_frame : 0) < (b.used ? b.last_frame : 0);
  });
  NEPHO_ASSERT(!oldest->used || oldest->last_frame < frame_);
  if (oldest->used) slot_of_.erase(oldest->tile);
  *oldest = {tile, true, frame_, frame_};
  const auto index = static_cast<uint32_t>(oldest - slots_.begin());
  slot_of_[tile] = index;
  return index;
}

void TileAtlas::upload(std::span<const Upload> tiles) {
  if (tiles.empty()) return;
  std::vector<gpu::ImageUpload> images;
  std::vector<gpu::BufferUpload> buffers;
  for (const Upload& u : tiles) {
    const uint32_t slot = take_slot(u.tile);
    for (uint32_t m = 0; m < u.data->imagery.size(); ++m)
      images.push_back({&imagery_, bytes_of(u.data->imagery[m]), m, slot});
    for (uint32_t m = 0; m < u.data->slopes.size(); ++m)
      images.push_back({&slopes_, bytes_of(u.data->slopes[m]), m, slot});
    buffers.push_back({&vertices_, uint64_t{slot} * kTileVertices * sizeof(TileVertex), bytes_of(u.data->vertices)});
  }
  device_.upload(images, buffers);
}

}  // namespace nepho
