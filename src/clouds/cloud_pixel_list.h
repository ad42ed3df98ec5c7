#pragma once
#include <glm/vec4.hpp>

#include "gpu/frame_graph.h"

namespace nepho {

/// Pixels that passes of the clouds draw in one frame where they do not draw all (shaders/clouds/pixel_list.glsl).
struct CloudPixelList {
  BufferRef pixels;                 ///< x | y << 16
  BufferRef groups_64, groups_256;  ///< dispatches for groups of so many threads; their fourth number: pixels
  explicit operator bool() const { return static_cast<bool>(pixels); }
};

/// Binds a list to a pass whose shader includes clouds/pixel_list.glsl, and its dispatch where there is one.
inline void bind_pixel_list(FrameGraph& graph, FrameGraph::PassBuilder& pass, const CloudPixelList& list,
                            uint32_t group_size) {
  if (!list) {
    const BufferRef none = graph.constants("clouds.no_list", glm::uvec4(0u));
    pass.read("pixel_list", none).read("pixel_count", none);
    return;
  }
  const BufferRef groups = group_size == 64 ? list.groups_64 : list.groups_256;
  pass.read("pixel_list", list.pixels).read("pixel_count", groups).indirect(groups);
}

}  // namespace nepho
