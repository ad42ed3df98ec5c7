#pragma once
#include <vector>

#include "gpu/frame_graph.h"

namespace nepho::gpu {

/// Where a use of a resource happens: an index into FrameGraph::resources(), and for history resources whether it is
/// last frame's image or this frame's.
struct Slot {
  uint32_t resource = 0;
  bool previous = false;
  auto operator<=>(const Slot&) const = default;
};

/// A barrier to be recorded before a pass.
struct CompiledBarrier {
  Slot slot;
  ResourceState from;  ///< for the first use in the frame: stage NONE, to be replaced by the resource's own last state
  ResourceState to;
  bool first_use = false;
  bool discard = false;  ///< contents before are not needed: the old layout is UNDEFINED
};

struct CompiledPass {
  uint32_t pass = 0;  ///< index into FrameGraph::passes()
  std::vector<CompiledBarrier> barriers;
};

/// Lifetime of a transient resource, and the physical one that it is placed in: two with disjoint lifetimes and equal
/// descriptions share one.
struct Placement {
  uint32_t resource = 0;
  uint32_t first_pass = 0;  ///< positions in CompiledGraph::passes, inclusive
  uint32_t last_pass = 0;
  uint32_t physical = 0;
};

struct CompiledGraph {
  std::vector<CompiledPass> passes;  ///< in order, without the culled ones
  std::vector<Placement> placements;
  uint32_t physical_count = 0;
  std::vector<std::string> culled;                           ///< names of passes whose outputs nobody uses
  std::vector<std::pair<Slot, ResourceState>> final_states;  ///< after the last pass
};

/// Pure: no device. Throws Error(failure) naming pass and resource when a transient is read before anything wrote it,
/// or a pass uses one resource in two ways that need different layouts.
CompiledGraph compile(const FrameGraph& graph);

/// Stage, access and layout of a use.
ResourceState state_of(const GraphUse& use, bool is_image, bool is_depth, bool raster_pass);
bool writes(Access access);

}  // namespace nepho::gpu
