#include "gpu/frame_graph_compile.h"

#include <algorithm>
#include <map>

#include "base/error.h"

namespace nepho::gpu {

bool writes(Access access) {
  switch (access) {
    case Access::storage_write:
    case Access::storage_read_write:
    case Access::color_attachment:
    case Access::depth_attachment:
    case Access::transfer_target:
      return true;
    default:
      return false;
  }
}

ResourceState state_of(const GraphUse& use, bool is_image, bool /*is_depth*/, bool raster_pass) {
  const VkPipelineStageFlags2 shader =
      raster_pass ? VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT
                  : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
  const auto layout = [&](VkImageLayout l) { return is_image ? l : VK_IMAGE_LAYOUT_UNDEFINED; };
  switch (use.access) {
    case Access::sampled:
      return {shader, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, layout(VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
    case Access::storage_read:
      return {shader, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, layout(VK_IMAGE_LAYOUT_GENERAL)};
    case Access::storage_write:
      return {shader, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, layout(VK_IMAGE_LAYOUT_GENERAL)};
    case Access::storage_read_write:
      return {shader, VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
              layout(VK_IMAGE_LAYOUT_GENERAL)};
    case Access::uniform:
      return {shader, VK_ACCESS_2_UNIFORM_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};
    case Access::color_attachment:
      return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
              VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
              VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    case Access::depth_attachment:
      return {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
              VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
              VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};
    case Access::index_buffer:
      return {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};
    case Access::indirect:
      return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};
    case Access::transfer_source:
      return {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
              layout(VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)};
    case Access::transfer_target:
      return {VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_CLEAR_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
              layout(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL)};
  }
  return {};
}

namespace {

/// Passes that lead to something kept, imported, remembered or with an effect.
std::vector<bool> needed_passes(const FrameGraph& graph) {
  const auto& resources = graph.resources();
  std::vector<bool> wanted(resources.size());
  for (size_t i = 0; i < resources.size(); ++i)
    wanted[i] =
        resources[i].kept || resources[i].history || resources[i].imported_image || resources[i].imported_buffer;
  std::vector<bool> needed(graph.passes().size());
  for (size_t i = graph.passes().size(); i-- > 0;) {
    const GraphPass& pass = graph.passes()[i];
    needed[i] = pass.has_effect || std::any_of(pass.uses.begin(), pass.uses.end(), [&](const GraphUse& u) {
                  return writes(u.access) && wanted[u.resource];
                });
    if (!needed[i]) continue;
    // Partial writes are legal, so earlier writers of what this pass writes stay needed as well.
    for (const GraphUse& u : pass.uses) wanted[u.resource] = true;
  }
  return needed;
}

struct SlotUse {
  ResourceState state;
  bool any_write = false;
  bool discard = false;
};

/// All uses of one slot in one pass, merged.
std::map<Slot, SlotUse> merged_uses(const FrameGraph& graph, const GraphPass& pass) {
  std::map<Slot, SlotUse> out;
  for (const GraphUse& u : pass.uses) {
    const GraphResource& r = graph.resources()[u.resource];
    const ResourceState state = state_of(u, r.is_image, r.image.format == Format::d32f, pass.raster);
    const auto [it, fresh] = out.try_emplace(Slot{u.resource, u.previous});
    SlotUse& merged = it->second;
    if (!fresh && merged.state.layout != state.layout)
      throw fail(ErrorKind::failure, "frame graph: pass {} uses {} in two ways that need different image layouts",
                 pass.name, r.name);
    merged.state.stages |= state.stages;
    merged.state.access |= state.access;
    merged.state.layout = state.layout;
    merged.any_write = merged.any_write || writes(u.access);
    merged.discard = merged.discard || u.clear;
  }
  return out;
}

/// Gives transients physical slots, first fit among equal descriptions with a finished lifetime.
void place(const FrameGraph& graph, CompiledGraph& out) {
  std::map<uint32_t, Placement> lifetimes;
  for (uint32_t position = 0; position < out.passes.size(); ++position) {
    for (const GraphUse& u : graph.passes()[out.passes[position].pass].uses) {
      const GraphResource& r = graph.resources()[u.resource];
      if (r.imported_image || r.imported_buffer || r.history) continue;
      const auto [it, fresh] = lifetimes.try_emplace(u.resource, Placement{u.resource, position, position, 0});
      it->second.last_pass = position;
    }
  }
  for (auto& [resource, p] : lifetimes)
    if (graph.resources()[resource].kept) p.last_pass = static_cast<uint32_t>(out.passes.size());
  for (auto& [resource, p] : lifetimes) out.placements.push_back(p);
  std::stable_sort(out.placements.begin(), out.placements.end(),
                   [](const Placement& a, const Placement& b) { return a.first_pass < b.first_pass; });
  std::vector<std::pair<uint32_t, uint32_t>> physical;  // (a resource with its description, last pass)
  for (Placement& p : out.placements) {
    const GraphResource& r = graph.resources()[p.resource];
    bool found = false;
    for (uint32_t i = 0; i < physical.size() && !found; ++i) {
      const GraphResource& other = graph.resources()[physical[i].first];
      const bool alike = r.is_image == other.is_image && r.contents.empty() && other.contents.empty() &&
                         (r.is_image ? r.image == other.image : r.buffer == other.buffer);
      if (!alike || physical[i].second >= p.first_pass) continue;
      p.physical = i;
      physical[i].second = p.last_pass;
      found = true;
    }
    if (!found) {
      p.physical = static_cast<uint32_t>(physical.size());
      physical.emplace_back(p.resource, p.last_pass);
    }
  }
  out.physical_count = static_cast<uint32_t>(physical.size());
}

}  // namespace

CompiledGraph compile(const FrameGraph& graph) {
  CompiledGraph out;
  const std::vector<bool> needed = needed_passes(graph);

  struct Known {
    ResourceState state;
    bool written = false;  // in this state
    size_t pass = 0, barrier = 0;
  };
  std::map<Slot, Known> known;
  std::vector<bool> has_contents(graph.resources().size());
  for (size_t i = 0; i < has_contents.size(); ++i) {
    const GraphResource& r = graph.resources()[i];
    has_contents[i] = r.imported_image || r.imported_buffer || !r.contents.empty();
  }

  for (uint32_t i = 0; i < graph.passes().size(); ++i) {
    const GraphPass& pass = graph.passes()[i];
    if (!needed[i]) {
      out.culled.push_back(pass.name);
      continue;
    }
    CompiledPass compiled{i, {}};
    for (const auto& [slot, use] : merged_uses(graph, pass)) {
      const GraphResource& r = graph.resources()[slot.resource];
      if (!slot.previous && !has_contents[slot.resource]) {
        if (!use.any_write)
          throw fail(ErrorKind::failure, "frame graph: pass {} reads {} before any pass wrote it", pass.name, r.name);
        has_contents[slot.resource] = true;
      }
      const auto it = known.find(slot);
      if (it == known.end()) {
        const bool transient = !r.imported_image && !r.imported_buffer && !slot.previous && r.contents.empty();
        compiled.barriers.push_back({slot, {}, use.state, true, transient || use.discard});
        known[slot] = {use.state, use.any_write, out.passes.size(), compiled.barriers.size() - 1};
        continue;
      }
      Known& k = it->second;
      if (!k.written && !use.any_write && k.state.layout == use.state.layout) {
        // Read after read: widen the barrier that made the data visible to the first reader.
        k.state.stages |= use.state.stages;
        k.state.access |= use.state.access;
        out.passes[k.pass].barriers[k.barrier].to = k.state;
        continue;
      }
      compiled.barriers.push_back({slot, k.state, use.state, false, use.discard});
      k = {use.state, use.any_write, out.passes.size(), compiled.barriers.size() - 1};
    }
    out.passes.push_back(std::move(compiled));
  }
  for (uint32_t i = 0; i < graph.resources().size(); ++i) {
    const GraphResource& r = graph.resources()[i];
    if (r.kept && !has_contents[i])
      throw fail(ErrorKind::failure, "frame graph: {} is kept but no pass writes it", r.name);
  }
  for (const auto& [slot, k] : known) out.final_states.emplace_back(slot, k.state);
  place(graph, out);
  return out;
}

}  // namespace nepho::gpu
