#pragma once
#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace nepho::gpu {

/// A driver's compiled pipelines, kept in cache_dir() from one start to the next: one file for each device and driver
/// (base/blob_cache.h says what becomes of torn files). Programs that end at the same time add to each other's.
class PipelineCache {
 public:
  PipelineCache(VkPhysicalDevice physical, VkDevice device);
  /// Stores what has been compiled since.
  ~PipelineCache();
  PipelineCache(const PipelineCache&) = delete;
  PipelineCache& operator=(const PipelineCache&) = delete;
  VkPipelineCache handle() const { return handle_; }
  uint64_t loaded_bytes() const { return loaded_bytes_; }  ///< that the file had; 0: there was none, or a bad one

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkPipelineCache handle_ = VK_NULL_HANDLE;
  uint64_t key_ = 0, loaded_bytes_ = 0, loaded_checksum_ = 0;
};

}  // namespace nepho::gpu
