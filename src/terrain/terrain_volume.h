#pragma once
#include "gpu/frame_graph.h"

namespace nepho {

/// Shadows of terrain in the air of a frame, for shaders that include terrain/terrain_air.glsl.
struct TerrainVolumeRefs {
  ImageRef shadow;    ///< rgba32f, a layer per level
  BufferRef map;      ///< shared::RegionMap
  ImageRef lit = {};  ///< r32f: 1 where no shadow is near the ground, for terrain_shadow.comp
  explicit operator bool() const { return static_cast<bool>(shadow); }
};
inline void bind_terrain_volume(FrameGraph::PassBuilder& pass, const TerrainVolumeRefs& refs) {
  pass.sample("terrain_volume_tex", refs.shadow).uniform("terrain_volume", refs.map);
}

}  // namespace nepho
