#pragma once
#include <vulkan/vulkan_core.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "gpu/types.h"

namespace nepho::gpu {

struct DeviceInfo {
  uint32_t index = 0;        ///< position in list_devices()
  std::string name;          ///< as the driver reports it
  std::string driver;        ///< driver name and version
  std::string api_version;   ///< Vulkan version of the device, "1.3.230"
  bool is_software = false;  ///< a CPU implementation such as lavapipe
  bool usable = false;       ///< has every feature that we need
  std::string why_not;       ///< what is missing, when not usable
};

/// Every Vulkan device of this machine, usable or not. Empty without a Vulkan driver.
std::vector<DeviceInfo> list_devices();

struct DeviceOptions {
  std::string device = {};  ///< index, or part of the name (case ignored); empty: a real GPU first, else software
  bool validation = false;  ///< Khronos validation layer with synchronisation validation; messages are collected
};

class Device;
class PipelineCache;

namespace detail {
/// Move-only base of GPU objects: knows its device.
struct Owned {
  Device* device = nullptr;
};
}  // namespace detail

struct ImageCreate {
  std::string name;
  Extent3D extent;
  Format format = Format::rgba16f;
  uint32_t mip_levels = 1;
  uint32_t layers = 1;
  bool cube = false;
};

struct BufferCreate {
  std::string name;
  uint64_t size_bytes = 0;
  bool host_visible = false;  ///< mapped for the CPU, see Buffer::mapped()
};

/// The stage, access and layout of the last use of a resource, from which the next barrier follows.
struct ResourceState {
  VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
  VkAccessFlags2 access = VK_ACCESS_2_NONE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  bool operator==(const ResourceState&) const = default;
};

/// A GPU image that outlives frames. Move-only; freed once the GPU is past its last use.
class Image {
 public:
  Image() = default;
  Image(Image&& other) noexcept { *this = std::move(other); }
  Image& operator=(Image&& other) noexcept;
  ~Image();
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
  const std::string& name() const { return name_; }
  const ImageDesc& desc() const { return desc_; }
  VkImage handle() const { return handle_; }
  uint64_t size_bytes() const { return size_bytes_; }  ///< device memory taken
  /// View of all mips (mip = kAllMips) or one; storage views of cubes are 2D arrays.
  static constexpr uint32_t kAllMips = ~0u;
  VkImageView view(bool storage, uint32_t mip = kAllMips) const;
  mutable ResourceState state;  ///< kept by the executor

 private:
  friend class Device;
  Device* device_ = nullptr;
  std::string name_;
  ImageDesc desc_;
  VkImage handle_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  uint64_t size_bytes_ = 0;
  mutable std::vector<std::pair<uint64_t, VkImageView>> views_;  // (storage << 32 | mip) -> view
};

/// A GPU buffer that outlives frames. Move-only.
class Buffer {
 public:
  Buffer() = default;
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }
  Buffer& operator=(Buffer&& other) noexcept;
  ~Buffer();
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
  const std::string& name() const { return name_; }
  const BufferDesc& desc() const { return desc_; }
  VkBuffer handle() const { return handle_; }
  void* mapped() const { return mapped_; }  ///< null unless host visible
  mutable ResourceState state;

 private:
  friend class Device;
  Device* device_ = nullptr;
  std::string name_;
  BufferDesc desc_;
  VkBuffer handle_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void* mapped_ = nullptr;
};

/// One rectangle of texels to copy into one mip and layer of an image. Tightly packed, rows top first.
struct ImageUpload {
  const Image* image = nullptr;
  std::span<const std::byte> bytes;
  uint32_t mip = 0;
  uint32_t layer = 0;
};

/// Bytes to copy into a buffer.
struct BufferUpload {
  const Buffer* buffer = nullptr;
  uint64_t offset_bytes = 0;
  std::span<const std::byte> bytes;
};

/// A Vulkan 1.3 device with one queue. Throws Error(device) when none is usable or the asked one is absent.
class Device {
 public:
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const { return info_; }
  Image create_image(const ImageCreate& create);
  Buffer create_buffer(const BufferCreate& create);

  /// Copies at once; returns when the GPU has the data. Images end in the sampled state.
  void upload(std::span<const ImageUpload> images, std::span<const BufferUpload> buffers = {});
  /// All texels of one mip, every layer, tightly packed. Waits for the GPU.
  std::vector<std::byte> download(const Image& image, uint32_t mip = 0);
  std::vector<std::byte> download(const Buffer& buffer);

  /// Messages of the validation layer since the last call, errors and warnings. Empty without validation.
  std::vector<std::string> take_validation_messages();
  bool validation_active() const { return validation_; }
  void wait_idle();
  /// Memory in use now, by what it is for.
  struct MemoryUse {
    uint64_t images = 0, buffers = 0;
    uint64_t host_visible = 0;  ///< buffers that the CPU writes and reads
    uint64_t total() const { return images + buffers + host_visible; }
  };
  const MemoryUse& memory_use() const { return memory_use_; }
  uint64_t memory_bytes() const { return memory_use_.total(); }

  // For the module itself.
  VkDevice handle() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkQueue queue() const { return queue_; }
  uint32_t queue_family() const { return queue_family_; }
  float timestamp_period_ns() const { return timestamp_period_ns_; }
  VkSampler sampler(Sampler sampler) const { return samplers_[static_cast<size_t>(sampler)]; }
  VkPipelineCache pipeline_cache() const;
  void set_name(VkObjectType type, uint64_t handle, const std::string& name) const;
  void begin_label(VkCommandBuffer cmd, const std::string& name) const;
  void end_label(VkCommandBuffer cmd) const;
  PFN_vkCmdPushDescriptorSetKHR push_descriptor_set = nullptr;
  /// Records `record` into a command buffer, submits it and waits.
  template <typename F>
  void submit_and_wait(F&& record) {
    VkCommandBuffer cmd = begin_commands();
    record(cmd);
    end_commands_and_wait(cmd);
  }

 private:
  friend class Image;
  friend class Buffer;
  VkDeviceMemory allocate(const VkMemoryRequirements& needs, bool host_visible, const std::string& name);
  uint64_t& use_of(const Buffer& buffer) { return buffer.mapped_ ? memory_use_.host_visible : memory_use_.buffers; }
  VkCommandBuffer begin_commands();
  void end_commands_and_wait(VkCommandBuffer cmd);
  void release(Image& image);
  void release(Buffer& buffer);
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                   VkDebugUtilsMessageTypeFlagsEXT,
                                                   const VkDebugUtilsMessengerCallbackDataEXT*, void*);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  uint32_t queue_family_ = 0;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::unique_ptr<PipelineCache> pipeline_cache_;
  VkSampler samplers_[4] = {};
  VkPhysicalDeviceMemoryProperties memory_types_{};
  float timestamp_period_ns_ = 1.0f;
  DeviceInfo info_;
  bool validation_ = false;
  bool debug_utils_ = false;
  MemoryUse memory_use_;
  std::mutex messages_mutex_;
  std::vector<std::string> messages_;
  PFN_vkSetDebugUtilsObjectNameEXT set_object_name_ = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT cmd_begin_label_ = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT cmd_end_label_ = nullptr;
};

}  // namespace nepho::gpu
