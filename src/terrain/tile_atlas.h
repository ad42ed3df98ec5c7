#pragma once
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gpu/device.h"
#include "terrain/tile_builder.h"

namespace nepho {

/// Tiles on the GPU: a slot each in two texture arrays and in the vertex buffer. What was not used for longest makes
/// room.
class TileAtlas {
 public:
  /// The vertices of this many stay below 128 MiB, the largest storage buffer that every device has.
  static constexpr uint32_t kMostSlots = 960;

  /// Room for `slots` tiles at first and `most_slots` after grow(), both at most kMostSlots.
  TileAtlas(gpu::Device& device, uint32_t slots, uint32_t most_slots);

  /// Bytes of one slot on the GPU.
  static uint64_t slot_bytes();
  uint32_t slots() const { return static_cast<uint32_t>(slots_.size()); }
  uint32_t most_slots() const { return most_slots_; }
  /// Makes room for at least `slots` tiles, at most most_slots(); forgets all tiles when it has to.
  void grow(uint32_t slots);

  /// A new frame: what find() and upload() see from here on is used in it.
  void begin_frame() { ++frame_; }
  /// The slot of a tile, which is then in use in this frame.
  std::optional<uint32_t> find(const TileId& tile);
  /// The same without using it.
  std::optional<uint32_t> peek(const TileId& tile) const;
  /// Frames since the tile was uploaded; 0 in the same frame.
  uint64_t age(const TileId& tile) const;
  /// True while a slot is free or was not used in this frame.
  bool has_room() const;

  struct Upload {
    TileId tile;
    const TileData* data;
  };
  /// Copies tiles into slots, the one that a tile has already or one that has_room(). Returns when the data may go.
  void upload(std::span<const Upload> tiles);

  const gpu::Image& imagery() const { return imagery_; }     ///< rgba8 in sRGB codes, a layer per slot (TileData)
  const gpu::Image& slopes() const { return slopes_; }       ///< rg16f, a layer per slot
  const gpu::Buffer& vertices() const { return vertices_; }  ///< kTileVertices TileVertex per slot
  uint64_t bytes() const;                                    ///< on the GPU

 private:
  struct Slot {
    TileId tile;
    bool used = false;
    uint64_t last_frame = 0, first_frame = 0;
  };
  void make_images(uint32_t slots);
  uint32_t take_slot(const TileId& tile);

  gpu::Device& device_;
  uint32_t most_slots_;
  gpu::Image imagery_, slopes_;
  gpu::Buffer vertices_;
  std::vector<Slot> slots_;
  std::unordered_map<TileId, uint32_t> slot_of_;
  uint64_t frame_ = 0;
};

}  // namespace nepho
