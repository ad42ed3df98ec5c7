#include "gpu/graph_executor.h"

#include <algorithm>
#include <chrono>

#include "base/error.h"
#include "gpu/commands.h"
#include "gpu/vulkan_names.h"

namespace nepho::gpu {

/// One graph being run: where each of its resources lives.
struct GraphExecutor::Frame {
  const FrameGraph* graph = nullptr;
  CompiledGraph compiled;
  std::vector<Image> images;    // by physical slot
  std::vector<Buffer> buffers;  // by physical slot
  std::map<uint32_t, uint32_t> physical_of;
  std::map<Slot, const Image*> history;
  std::vector<std::string> names;  // of resources, for messages after the graph is gone
  std::vector<bool> kept;

  const Image* image(Slot slot) const {
    const GraphResource& r = graph->resources()[slot.resource];
    if (r.imported_image) return r.imported_image;
    if (r.history) return history.at(slot);
    return &images[physical_of.at(slot.resource)];
  }
  const Buffer* buffer(Slot slot) const {
    const GraphResource& r = graph->resources()[slot.resource];
    return r.imported_buffer ? r.imported_buffer : &buffers[physical_of.at(slot.resource)];
  }
};

GraphExecutor::GraphExecutor(Device& device) : device_(device) {}
GraphExecutor::~GraphExecutor() = default;

void GraphExecutor::prepare(Frame& frame) {
  const FrameGraph& graph = *frame.graph;
  frame.compiled = compile(graph);
  frame.images.resize(frame.compiled.physical_count);
  frame.buffers.resize(frame.compiled.physical_count);
  for (const GraphResource& r : graph.resources()) {
    frame.names.push_back(r.name);
    frame.kept.push_back(r.kept);
  }
  for (const Placement& p : frame.compiled.placements) {
    const GraphResource& r = graph.resources()[p.resource];
    frame.physical_of[p.resource] = p.physical;
    if (r.is_image && !frame.images[p.physical]) {
      const auto pooled =
          std::find_if(image_pool_.begin(), image_pool_.end(), [&](const Image& i) { return i.desc() == r.image; });
      if (pooled != image_pool_.end()) {
        frame.images[p.physical] = std::move(*pooled);
        image_pool_.erase(pooled);
      } else {
        frame.images[p.physical] = device_.create_image(
            {r.name, r.image.extent, r.image.format, r.image.mip_levels, r.image.layers, r.image.cube});
      }
    } else if (!r.is_image && !frame.buffers[p.physical]) {
      const bool host = !r.contents.empty();
      const auto pooled = std::find_if(buffer_pool_.begin(), buffer_pool_.end(), [&](const Buffer& b) {
        return b.desc() == r.buffer && (b.mapped() != nullptr) == host;
      });
      if (pooled != buffer_pool_.end()) {
        frame.buffers[p.physical] = std::move(*pooled);
        buffer_pool_.erase(pooled);
      } else {
        frame.buffers[p.physical] =
            device_.create_buffer({.name = r.name, .size_bytes = r.buffer.size_bytes, .host_visible = host});
      }
      // Written before the submission, which makes host writes visible.
      if (host) std::memcpy(frame.buffers[p.physical].mapped(), r.contents.data(), r.contents.size());
    }
  }
  for (uint32_t i = 0; i < graph.resources().size(); ++i) {
    const GraphResource& r = graph.resources()[i];
    if (!r.history) continue;
    History& h = history_[r.name];
    if (!h.images[0] || !(h.images[0].desc() == r.image)) {
      for (Image& image : h.images)
        image = device_.create_image(
            {r.name, r.image.extent, r.image.format, r.image.mip_levels, r.image.layers, r.image.cube});
      h.fresh = true;
    }
  }
}

namespace {
void record_image_barrier(std::vector<VkImageMemoryBarrier2>& out, const Image& image, const ResourceState& to,
                          bool discard) {
  auto b = vk_struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  b.srcStageMask = image.state.stages;
  b.srcAccessMask = image.state.access;
  b.dstStageMask = to.stages;
  b.dstAccessMask = to.access;
  b.oldLayout = discard ? VK_IMAGE_LAYOUT_UNDEFINED : image.state.layout;
  b.newLayout = to.layout;
  b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  b.image = image.handle();
  const bool depth = image.desc().format == Format::d32f;
  b.subresourceRange = {depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                        VK_REMAINING_ARRAY_LAYERS};
  out.push_back(b);
  image.state = to;
}

void record_barriers(VkCommandBuffer cmd, const std::vector<VkImageMemoryBarrier2>& images,
                     const std::vector<VkBufferMemoryBarrier2>& buffers) {
  if (images.empty() && buffers.empty()) return;
  auto info = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
  info.pImageMemoryBarriers = images.data();
  info.bufferMemoryBarrierCount = static_cast<uint32_t>(buffers.size());
  info.pBufferMemoryBarriers = buffers.data();
  vkCmdPipelineBarrier2(cmd, &info);
}

void clear_to_zero(VkCommandBuffer cmd, const Image& image) {
  std::vector<VkImageMemoryBarrier2> barriers;
  record_image_barrier(
      barriers, image,
      {VK_PIPELINE_STAGE_2_CLEAR_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL}, true);
  record_barriers(cmd, barriers, {});
  const VkClearColorValue zero{};
  const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                    VK_REMAINING_ARRAY_LAYERS};
  vkCmdClearColorImage(cmd, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &zero, 1, &all);
}

void begin_rendering(VkCommandBuffer cmd, const GraphPass& pass, const std::vector<const Image*>& images) {
  std::vector<VkRenderingAttachmentInfo> colors;
  auto depth = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  bool has_depth = false;
  Extent3D extent;
  for (size_t i = 0; i < pass.uses.size(); ++i) {
    const GraphUse& u = pass.uses[i];
    if (u.access != Access::color_attachment && u.access != Access::depth_attachment) continue;
    auto a = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
    a.imageView = images[i]->view(false, 0);
    a.imageLayout = images[i]->state.layout;
    a.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    extent = images[i]->desc().extent;
    if (u.access == Access::depth_attachment) {
      a.clearValue.depthStencil.depth = u.clear_value[0];
      depth = a;
      has_depth = true;
    } else {
      // Integer attachments are cleared to zero, whose bits agree.
      std::memcpy(a.clearValue.color.float32, u.clear_value, sizeof(u.clear_value));
      colors.push_back(a);
    }
  }
  auto info = vk_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = {extent.width, extent.height};
  info.layerCount = 1;
  info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
  info.pColorAttachments = colors.data();
  info.pDepthAttachment = has_depth ? &depth : nullptr;
  vkCmdBeginRendering(cmd, &info);
  const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, {extent.width, extent.height}};
  vkCmdSetViewport(cmd, 0, 1, &viewport);
  vkCmdSetScissor(cmd, 0, 1, &scissor);
}
}  // namespace

void GraphExecutor::begin_history(Frame& frame, VkCommandBuffer cmd) {
  const FrameGraph& graph = *frame.graph;
  for (uint32_t i = 0; i < graph.resources().size(); ++i) {
    const GraphResource& r = graph.resources()[i];
    if (!r.history) continue;
    History& h = history_.at(r.name);
    if (h.fresh) {
      for (const Image& image : h.images) clear_to_zero(cmd, image);
      h.fresh = false;
    }
    h.current ^= 1u;
    frame.history[{i, false}] = &h.images[h.current];
    frame.history[{i, true}] = &h.images[h.current ^ 1u];
  }
}

void GraphExecutor::record_pass(Frame& frame, const CompiledPass& compiled, VkCommandBuffer cmd) {
  const FrameGraph& graph = *frame.graph;
  const GraphPass& pass = graph.passes()[compiled.pass];
  device_.begin_label(cmd, pass.name);
  std::vector<VkImageMemoryBarrier2> image_barriers;
  std::vector<VkBufferMemoryBarrier2> buffer_barriers;
  for (const CompiledBarrier& b : compiled.barriers) {
    const GraphResource& r = graph.resources()[b.slot.resource];
    if (r.is_image) {
      const Image& image = *frame.image(b.slot);
      const bool undefined = image.state.layout == VK_IMAGE_LAYOUT_UNDEFINED;
      record_image_barrier(image_barriers, image, b.to, b.discard || undefined);
    } else {
      const Buffer& buffer = *frame.buffer(b.slot);
      if (buffer.state.stages == VK_PIPELINE_STAGE_2_NONE) {  // nothing to wait for
        buffer.state = b.to;
        continue;
      }
      auto barrier = vk_struct<VkBufferMemoryBarrier2>(VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2);
      barrier.srcStageMask = buffer.state.stages;
      barrier.srcAccessMask = buffer.state.access;
      barrier.dstStageMask = b.to.stages;
      barrier.dstAccessMask = b.to.access;
      barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      barrier.buffer = buffer.handle();
      barrier.size = VK_WHOLE_SIZE;
      buffer_barriers.push_back(barrier);
      buffer.state = b.to;
    }
  }
  record_barriers(cmd, image_barriers, buffer_barriers);

  Commands commands;
  commands.device_ = &device_;
  commands.cmd_ = cmd;
  commands.pass_ = &pass;
  std::vector<const Image*> images;
  for (const GraphUse& u : pass.uses) {
    const Slot slot{u.resource, u.previous};
    const bool is_image = graph.resources()[u.resource].is_image;
    const Image* image = is_image ? frame.image(slot) : nullptr;
    const Buffer* buffer = is_image ? nullptr : frame.buffer(slot);
    images.push_back(image);
    if (!u.binding.empty()) commands.bound_.push_back({&u, image, buffer});
    if (u.access == Access::indirect) commands.indirect_ = buffer;
    if (u.access == Access::index_buffer) vkCmdBindIndexBuffer(cmd, buffer->handle(), 0, VK_INDEX_TYPE_UINT32);
  }
  if (pass.raster) begin_rendering(cmd, pass, images);
  if (pass.record) pass.record(commands);
  if (pass.raster) vkCmdEndRendering(cmd);
  device_.end_label(cmd);
}

void GraphExecutor::run(const FrameGraph& graph) { run(std::vector<const FrameGraph*>{&graph}); }

void GraphExecutor::run(const std::vector<const FrameGraph*>& graphs) {
  const auto recycle = [&](Frame& frame) {
    for (Image& image : frame.images)
      if (image) image_pool_.push_back(std::move(image));
    for (Buffer& buffer : frame.buffers)
      if (buffer) buffer_pool_.push_back(std::move(buffer));
  };
  if (last_) recycle(*last_);
  last_.reset();
  std::vector<std::unique_ptr<Frame>> frames;
  for (const FrameGraph* graph : graphs) {
    auto frame = std::make_unique<Frame>();
    frame->graph = graph;
    prepare(*frame);
    frames.push_back(std::move(frame));
  }
  timings_.clear();
  if (device_.info().is_software && !device_.validation_active())
    run_pass_by_pass(frames);
  else
    run_in_one_submission(frames);
  for (size_t i = 0; i + 1 < frames.size(); ++i) recycle(*frames[i]);
  if (!frames.empty()) {
    last_ = std::move(frames.back());
    last_->graph = nullptr;  // the caller's graph may be gone by the time of a download
  }
}

void GraphExecutor::run_pass_by_pass(const std::vector<std::unique_ptr<Frame>>& frames) {
  for (const auto& frame : frames) {
    device_.submit_and_wait([&](VkCommandBuffer cmd) { begin_history(*frame, cmd); });
    for (const CompiledPass& pass : frame->compiled.passes) {
      const auto start = std::chrono::steady_clock::now();
      device_.submit_and_wait([&](VkCommandBuffer cmd) { record_pass(*frame, pass, cmd); });
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
      timings_.push_back({frame->graph->passes()[pass.pass].name, ms.count()});
    }
  }
}

void GraphExecutor::run_in_one_submission(const std::vector<std::unique_ptr<Frame>>& frames) {
  uint32_t query_count = 0;
  for (const auto& frame : frames) query_count += 2 * static_cast<uint32_t>(frame->compiled.passes.size());
  auto info = vk_struct<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = std::max(1u, query_count);
  VkQueryPool queries = VK_NULL_HANDLE;
  check(vkCreateQueryPool(device_.handle(), &info, nullptr, &queries), "vkCreateQueryPool");
  const auto destroy = [this](VkQueryPool pool) { vkDestroyQueryPool(device_.handle(), pool, nullptr); };
  const std::unique_ptr<VkQueryPool_T, decltype(destroy)> owner(queries, destroy);
  device_.submit_and_wait([&](VkCommandBuffer cmd) {
    vkCmdResetQueryPool(cmd, queries, 0, info.queryCount);
    uint32_t next = 0;
    for (const auto& frame : frames) {
      begin_history(*frame, cmd);
      for (const CompiledPass& pass : frame->compiled.passes) {
        vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries, next++);
        record_pass(*frame, pass, cmd);
        vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries, next++);
      }
    }
  });
  if (query_count == 0) return;
  std::vector<uint64_t> ticks(query_count);
  check(vkGetQueryPoolResults(device_.handle(), queries, 0, query_count, ticks.size() * sizeof(uint64_t), ticks.data(),
                              sizeof(uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  uint32_t q = 0;
  for (const auto& frame : frames)
    for (const CompiledPass& pass : frame->compiled.passes) {
      const double ns =
          static_cast<double>(ticks[q + 1] - ticks[q]) * static_cast<double>(device_.timestamp_period_ns());
      timings_.push_back({frame->graph->passes()[pass.pass].name, ns * 1e-6});
      q += 2;
    }
}

std::vector<std::byte> GraphExecutor::download(ImageRef image) {
  NEPHO_ASSERT(last_ != nullptr && image.index < last_->kept.size());
  if (const auto h = last_->history.find({image.index, false}); h != last_->history.end())
    return device_.download(*h->second);
  NEPHO_ASSERT(last_->kept[image.index]);
  return device_.download(last_->images[last_->physical_of.at(image.index)]);
}

std::vector<std::byte> GraphExecutor::download(BufferRef buffer) {
  NEPHO_ASSERT(last_ != nullptr && buffer.index < last_->kept.size() && last_->kept[buffer.index]);
  return device_.download(last_->buffers[last_->physical_of.at(buffer.index)]);
}

}  // namespace nepho::gpu
