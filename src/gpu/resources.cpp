// Images, buffers and copies between them and the CPU.
#include <algorithm>
#include <cstring>

#include "gpu/device.h"
#include "gpu/vulkan_names.h"

namespace nepho::gpu {

namespace {

VkImageAspectFlags aspect_of(Format format) {
  return format == Format::d32f ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

bool storable(Format format) { return format != Format::d32f && format != Format::rgba8_srgb; }

Extent3D mip_extent(const ImageDesc& desc, uint32_t mip) {
  return {std::max(1u, desc.extent.width >> mip), std::max(1u, desc.extent.height >> mip),
          std::max(1u, desc.extent.depth >> mip)};
}

VkBufferImageCopy copy_region(const ImageDesc& desc, uint32_t mip, uint32_t layer, uint32_t layers) {
  const Extent3D e = mip_extent(desc, mip);
  VkBufferImageCopy region{};
  region.imageSubresource = {aspect_of(desc.format), mip, layer, layers};
  region.imageExtent = {e.width, e.height, e.depth};
  return region;
}

void image_barrier(VkCommandBuffer cmd, const Image& image, ResourceState to, bool discard) {
  auto barrier = vk_struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  barrier.srcStageMask = image.state.stages;
  barrier.srcAccessMask = image.state.access;
  barrier.dstStageMask = to.stages;
  barrier.dstAccessMask = to.access;
  barrier.oldLayout = discard ? VK_IMAGE_LAYOUT_UNDEFINED : image.state.layout;
  barrier.newLayout = to.layout;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image.handle();
  barrier.subresourceRange = {aspect_of(image.desc().format), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  auto info = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  info.imageMemoryBarrierCount = 1;
  info.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(cmd, &info);
  image.state = to;
}

void buffer_barrier(VkCommandBuffer cmd, const Buffer& buffer, ResourceState to) {
  auto barrier = vk_struct<VkBufferMemoryBarrier2>(VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2);
  barrier.srcStageMask = buffer.state.stages;
  barrier.srcAccessMask = buffer.state.access;
  barrier.dstStageMask = to.stages;
  barrier.dstAccessMask = to.access;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.buffer = buffer.handle();
  barrier.size = VK_WHOLE_SIZE;
  auto info = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  info.bufferMemoryBarrierCount = 1;
  info.pBufferMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(cmd, &info);
  buffer.state = to;
}

constexpr ResourceState kCopyTo{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr ResourceState kCopyFrom{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                  VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
constexpr ResourceState kSampled{VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                 VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
constexpr ResourceState kHostRead{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};

}  // namespace

VkDeviceMemory Device::allocate(const VkMemoryRequirements& needs, bool host_visible, const std::string& name) {
  const VkMemoryPropertyFlags first = host_visible
                                          ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT |
                                                VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                          : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const VkMemoryPropertyFlags second =
      host_visible ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : 0u;
  for (const VkMemoryPropertyFlags wanted : {first, second}) {
    for (uint32_t i = 0; i < memory_types_.memoryTypeCount; ++i) {
      if (!(needs.memoryTypeBits & (1u << i)) || (memory_types_.memoryTypes[i].propertyFlags & wanted) != wanted)
        continue;
      auto info = vk_struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
      info.allocationSize = needs.size;
      info.memoryTypeIndex = i;
      VkDeviceMemory memory = VK_NULL_HANDLE;
      const VkResult result = vkAllocateMemory(device_, &info, nullptr, &memory);
      if (result == VK_SUCCESS) return memory;
      throw fail(ErrorKind::failure, "{}: {} bytes of GPU memory are not to be had ({}); try a smaller --size", name,
                 needs.size, vk_result_name(result));
    }
  }
  throw fail(ErrorKind::failure, "{}: the device has no fitting memory type", name);
}

Image Device::create_image(const ImageCreate& create) {
  Image image;
  image.device_ = this;
  image.name_ = create.name;
  image.desc_ = {create.extent, create.format, create.mip_levels, create.layers, create.cube};
  auto info = vk_struct<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.flags = create.cube ? static_cast<VkImageCreateFlags>(VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) : 0u;
  info.imageType = create.extent.depth > 1 ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D;
  info.format = vk_format(create.format);
  info.extent = {create.extent.width, create.extent.height, create.extent.depth};
  info.mipLevels = create.mip_levels;
  info.arrayLayers = create.layers;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (storable(create.format)) info.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
  if (create.format == Format::d32f)
    info.usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  else if (create.extent.depth == 1 && create.format != Format::rg16_snorm)
    info.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  // Drivers differ in what they can store or render to; ask, so that an odd format still serves as a texture.
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(physical_, info.format, &properties);
  if (!(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT))
    info.usage &= ~static_cast<VkImageUsageFlags>(VK_IMAGE_USAGE_STORAGE_BIT);
  if (!(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT))
    info.usage &= ~static_cast<VkImageUsageFlags>(VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  const VkResult result = vkCreateImage(device_, &info, nullptr, &image.handle_);
  if (result != VK_SUCCESS)
    throw fail(ErrorKind::failure, "image {} ({}x{}x{} {}) cannot be made: {}", create.name, create.extent.width,
               create.extent.height, create.extent.depth, name_of(create.format), vk_result_name(result));
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device_, image.handle_, &needs);
  image.memory_ = allocate(needs, false, create.name);
  image.size_bytes_ = needs.size;
  memory_use_.images += needs.size;
  check(vkBindImageMemory(device_, image.handle_, image.memory_, 0), "vkBindImageMemory");
  set_name(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<uint64_t>(image.handle_), create.name);
  return image;
}

Buffer Device::create_buffer(const BufferCreate& create) {
  NEPHO_ASSERT_OP(create.size_bytes, >, 0u);
  Buffer buffer;
  buffer.device_ = this;
  buffer.name_ = create.name;
  buffer.desc_ = {create.size_bytes};
  auto info = vk_struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = create.size_bytes;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
               VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  check(vkCreateBuffer(device_, &info, nullptr, &buffer.handle_), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer.handle_, &needs);
  buffer.memory_ = allocate(needs, create.host_visible, create.name);
  check(vkBindBufferMemory(device_, buffer.handle_, buffer.memory_, 0), "vkBindBufferMemory");
  if (create.host_visible)
    check(vkMapMemory(device_, buffer.memory_, 0, VK_WHOLE_SIZE, 0, &buffer.mapped_), "vkMapMemory");
  use_of(buffer) += needs.size;
  set_name(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(buffer.handle_), create.name);
  return buffer;
}

void Device::release(Image& image) {
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device_, image.handle_, &needs);
  memory_use_.images -= std::min(memory_use_.images, needs.size);
  for (const auto& [key, view] : image.views_) vkDestroyImageView(device_, view, nullptr);
  vkDestroyImage(device_, image.handle_, nullptr);
  vkFreeMemory(device_, image.memory_, nullptr);
}

void Device::release(Buffer& buffer) {
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer.handle_, &needs);
  use_of(buffer) -= std::min(use_of(buffer), needs.size);
  vkDestroyBuffer(device_, buffer.handle_, nullptr);
  vkFreeMemory(device_, buffer.memory_, nullptr);
}

// Every submission is waited for (Device::submit_and_wait), so nothing is in flight when an object dies.
Image::~Image() {
  if (handle_) device_->release(*this);
}

Image& Image::operator=(Image&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(desc_, other.desc_);
  std::swap(handle_, other.handle_);
  std::swap(memory_, other.memory_);
  std::swap(size_bytes_, other.size_bytes_);
  std::swap(views_, other.views_);
  std::swap(state, other.state);
  return *this;
}

VkImageView Image::view(bool storage, uint32_t mip) const {
  const bool as_array = desc_.layers > 1 && (!desc_.cube || storage);
  const uint64_t key = (static_cast<uint64_t>(storage && desc_.cube) << 32) | mip;
  for (const auto& [known, view] : views_)
    if (known == key) return view;
  auto info = vk_struct<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  info.image = handle_;
  info.viewType = desc_.extent.depth > 1 ? VK_IMAGE_VIEW_TYPE_3D
                  : as_array             ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                  : desc_.cube           ? VK_IMAGE_VIEW_TYPE_CUBE
                                         : VK_IMAGE_VIEW_TYPE_2D;
  info.format = vk_format(desc_.format);
  info.subresourceRange = {aspect_of(desc_.format), mip == kAllMips ? 0 : mip,
                           mip == kAllMips ? VK_REMAINING_MIP_LEVELS : 1, 0, VK_REMAINING_ARRAY_LAYERS};
  VkImageView view = VK_NULL_HANDLE;
  check(vkCreateImageView(device_->handle(), &info, nullptr, &view), "vkCreateImageView");
  views_.emplace_back(key, view);
  return view;
}

Buffer::~Buffer() {
  if (handle_) device_->release(*this);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(desc_, other.desc_);
  std::swap(handle_, other.handle_);
  std::swap(memory_, other.memory_);
  std::swap(mapped_, other.mapped_);
  std::swap(state, other.state);
  return *this;
}

void Device::upload(std::span<const ImageUpload> images, std::span<const BufferUpload> buffers) {
  uint64_t total = 0;
  const auto aligned = [](uint64_t n) { return (n + 15) & ~uint64_t{15}; };
  for (const ImageUpload& u : images) {
    const Extent3D e = mip_extent(u.image->desc(), u.mip);
    NEPHO_ASSERT_OP(u.bytes.size(), ==, size_t{e.width} * e.height * e.depth * bytes_per_texel(u.image->desc().format));
    total += aligned(u.bytes.size());
  }
  for (const BufferUpload& u : buffers) {
    NEPHO_ASSERT_OP(u.offset_bytes + u.bytes.size(), <=, u.buffer->desc().size_bytes);
    total += aligned(u.bytes.size());
  }
  if (total == 0) return;
  const Buffer staging = create_buffer({.name = "upload.staging", .size_bytes = total, .host_visible = true});
  auto* mapped = static_cast<std::byte*>(staging.mapped());
  submit_and_wait([&](VkCommandBuffer cmd) {
    std::vector<const Image*> distinct;
    for (const ImageUpload& u : images)
      if (std::find(distinct.begin(), distinct.end(), u.image) == distinct.end()) distinct.push_back(u.image);
    for (const Image* image : distinct)
      image_barrier(cmd, *image, kCopyTo, image->state.layout == VK_IMAGE_LAYOUT_UNDEFINED);
    uint64_t offset = 0;
    for (const ImageUpload& u : images) {
      std::memcpy(mapped + offset, u.bytes.data(), u.bytes.size());
      VkBufferImageCopy region = copy_region(u.image->desc(), u.mip, u.layer, 1);
      region.bufferOffset = offset;
      vkCmdCopyBufferToImage(cmd, staging.handle(), u.image->handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                             &region);
      offset += aligned(u.bytes.size());
    }
    for (const Image* image : distinct) image_barrier(cmd, *image, kSampled, false);
    std::vector<const Buffer*> touched;
    for (const BufferUpload& u : buffers) {
      if (u.bytes.empty()) continue;
      if (std::find(touched.begin(), touched.end(), u.buffer) == touched.end()) {
        buffer_barrier(cmd, *u.buffer, kCopyTo);
        touched.push_back(u.buffer);
      }
      std::memcpy(mapped + offset, u.bytes.data(), u.bytes.size());
      const VkBufferCopy region{offset, u.offset_bytes, u.bytes.size()};
      vkCmdCopyBuffer(cmd, staging.handle(), u.buffer->handle(), 1, &region);
      offset += aligned(u.bytes.size());
    }
  });
}

std::vector<std::byte> Device::download(const Image& image, uint32_t mip) {
  const Extent3D e = mip_extent(image.desc(), mip);
  const uint64_t size =
      uint64_t{e.width} * e.height * e.depth * image.desc().layers * bytes_per_texel(image.desc().format);
  const Buffer staging = create_buffer({.name = "download.staging", .size_bytes = size, .host_visible = true});
  submit_and_wait([&](VkCommandBuffer cmd) {
    image_barrier(cmd, image, kCopyFrom, false);
    const VkBufferImageCopy region = copy_region(image.desc(), mip, 0, image.desc().layers);
    vkCmdCopyImageToBuffer(cmd, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging.handle(), 1, &region);
    staging.state = kCopyTo;
    buffer_barrier(cmd, staging, kHostRead);
  });
  const auto* bytes = static_cast<const std::byte*>(staging.mapped());
  return {bytes, bytes + size};
}

std::vector<std::byte> Device::download(const Buffer& buffer) {
  const uint64_t size = buffer.desc().size_bytes;
  const Buffer staging = create_buffer({.name = "download.staging", .size_bytes = size, .host_visible = true});
  submit_and_wait([&](VkCommandBuffer cmd) {
    buffer_barrier(cmd, buffer, kCopyFrom);
    const VkBufferCopy region{0, 0, size};
    vkCmdCopyBuffer(cmd, buffer.handle(), staging.handle(), 1, &region);
    staging.state = kCopyTo;
    buffer_barrier(cmd, staging, kHostRead);
  });
  const auto* bytes = static_cast<const std::byte*>(staging.mapped());
  return {bytes, bytes + size};
}

}  // namespace nepho::gpu
