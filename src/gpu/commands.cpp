#include "gpu/commands.h"

#include "base/error.h"
#include "gpu/vulkan_names.h"

namespace nepho::gpu {

namespace {
bool is_storage(Access a) {
  return a == Access::storage_read || a == Access::storage_write || a == Access::storage_read_write;
}

bool fits(Access access, BindingKind kind, bool is_image) {
  switch (kind) {
    case BindingKind::sampled_image:
      return access == Access::sampled && is_image;
    case BindingKind::storage_image:
      return is_storage(access) && is_image;
    case BindingKind::uniform_buffer:
      return access == Access::uniform && !is_image;
    case BindingKind::storage_buffer:
      return is_storage(access) && !is_image;
  }
  return false;
}
}  // namespace

Commands& Commands::mip(const std::string& binding, uint32_t level) {
  mips_[binding] = level;
  return *this;
}

Commands& Commands::bind(const Pipeline& pipeline) {
  pipeline_ = &pipeline;
  vkCmdBindPipeline(cmd_, pipeline.bind_point(), pipeline.handle());
  const auto& bindings = pipeline.reflection().bindings;
  std::vector<VkWriteDescriptorSet> writes;
  std::vector<VkDescriptorImageInfo> images(bindings.size());
  std::vector<VkDescriptorBufferInfo> buffers(bindings.size());
  for (size_t i = 0; i < bindings.size(); ++i) {
    const ShaderBinding& b = bindings[i];
    const Bound* found = nullptr;
    for (const Bound& candidate : bound_)
      if (candidate.use->binding == b.name) found = &candidate;
    if (!found)
      throw fail(ErrorKind::failure, "pass {}: shader {} reads '{}', which the pass does not declare", pass_->name,
                 pipeline.name(), b.name);
    if (!fits(found->use->access, b.kind, found->image != nullptr))
      throw fail(ErrorKind::failure, "pass {}: '{}' of shader {} is declared as another kind of use", pass_->name,
                 b.name, pipeline.name());
    auto write = vk_struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstBinding = b.binding;
    write.descriptorCount = 1;
    if (found->image) {
      const bool storage = b.kind == BindingKind::storage_image;
      const auto mip = mips_.find(b.name);
      // A storage view shows one mip.
      const uint32_t level = mip != mips_.end() ? mip->second : (storage ? 0u : Image::kAllMips);
      images[i] = {storage ? VK_NULL_HANDLE : device_->sampler(found->use->sampler), found->image->view(storage, level),
                   storage ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      write.descriptorType = storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      write.pImageInfo = &images[i];
    } else {
      buffers[i] = {found->buffer->handle(), 0, VK_WHOLE_SIZE};
      write.descriptorType =
          b.kind == BindingKind::uniform_buffer ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
      write.pBufferInfo = &buffers[i];
    }
    writes.push_back(write);
  }
  mips_.clear();
  if (!writes.empty())
    device_->push_descriptor_set(cmd_, pipeline.bind_point(), pipeline.layout(), 0,
                                 static_cast<uint32_t>(writes.size()), writes.data());
  return *this;
}

Commands& Commands::push_bytes(const void* data, size_t size_bytes) {
  NEPHO_ASSERT(pipeline_ != nullptr);
  const uint32_t expected = pipeline_->reflection().push_constant_bytes;
  if (size_bytes != expected)
    throw fail(ErrorKind::failure, "pass {}: {} bytes of push constants, shader {} has {}", pass_->name, size_bytes,
               pipeline_->name(), expected);
  const VkShaderStageFlags stages = pipeline_->bind_point() == VK_PIPELINE_BIND_POINT_COMPUTE
                                        ? VK_SHADER_STAGE_COMPUTE_BIT
                                        : VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
  vkCmdPushConstants(cmd_, pipeline_->layout(), stages, 0, static_cast<uint32_t>(size_bytes), data);
  return *this;
}

Commands& Commands::dispatch_threads(uint32_t x, uint32_t y, uint32_t z) {
  NEPHO_ASSERT(pipeline_ != nullptr);
  const auto groups = [&](uint32_t n, int axis) {
    const uint32_t size = pipeline_->reflection().group_size[axis];
    return (n + size - 1) / size;
  };
  vkCmdDispatch(cmd_, groups(x, 0), groups(y, 1), groups(z, 2));
  return *this;
}

Commands& Commands::dispatch_indirect() {
  NEPHO_ASSERT(pipeline_ != nullptr);
  if (!indirect_) throw fail(ErrorKind::failure, "pass {}: declares no indirect buffer", pass_->name);
  vkCmdDispatchIndirect(cmd_, indirect_->handle(), 0);
  return *this;
}

Commands& Commands::draw_indexed(uint32_t index_count, uint32_t first_index, uint32_t instance_count,
                                 uint32_t first_instance) {
  vkCmdDrawIndexed(cmd_, index_count, instance_count, first_index, 0, first_instance);
  return *this;
}

Commands& Commands::draw(uint32_t vertex_count, uint32_t instance_count) {
  vkCmdDraw(cmd_, vertex_count, instance_count, 0, 0);
  return *this;
}

Commands& Commands::fill(const std::string& name, float r, float g, float b, float a) {
  for (const Bound& found : bound_)
    if (found.use->binding == name && found.image && found.use->access == Access::transfer_target) {
      const VkClearColorValue value{.float32 = {r, g, b, a}};
      const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                        VK_REMAINING_ARRAY_LAYERS};
      vkCmdClearColorImage(cmd_, found.image->handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &value, 1, &all);
      return *this;
    }
  throw fail(ErrorKind::failure, "pass {}: no image '{}' is declared to be filled", pass_->name, name);
}

Commands& Commands::zero(const std::string& name) {
  for (const Bound& b : bound_)
    if (b.use->binding == name && b.use->access == Access::transfer_target && b.buffer) {
      vkCmdFillBuffer(cmd_, b.buffer->handle(), 0, VK_WHOLE_SIZE, 0);
      return *this;
    }
  throw fail(ErrorKind::failure, "pass {}: no buffer '{}' is declared to be zeroed", pass_->name, name);
}

Commands& Commands::barrier() {
  auto memory = vk_struct<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  memory.srcStageMask = memory.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
  memory.srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
  memory.dstAccessMask =
      VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
  auto info = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(cmd_, &info);
  return *this;
}

}  // namespace nepho::gpu
