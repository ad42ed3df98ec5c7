#include "gpu/pipeline_cache.h"

#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "base/blob_cache.h"
#include "gpu/vulkan_names.h"

namespace nepho::gpu {
namespace {

/// Bumped when the program's use of pipelines changes so that old ones would only take room.
constexpr uint32_t kVersion = 1;

/// What has to agree for compiled code to be of use: the device, its driver and this program's version.
uint64_t key_of(VkPhysicalDevice physical) {
  VkPhysicalDeviceProperties p;
  vkGetPhysicalDeviceProperties(physical, &p);
  const uint32_t numbers[] = {kVersion, p.vendorID, p.deviceID, p.driverVersion};
  std::vector<std::byte> bytes(sizeof numbers + VK_UUID_SIZE);
  std::memcpy(bytes.data(), numbers, sizeof numbers);
  std::memcpy(bytes.data() + sizeof numbers, p.pipelineCacheUUID, VK_UUID_SIZE);
  return checksum_of(bytes.data(), bytes.size());
}

std::string name_of(uint64_t key) { return fmt::format("pipelines-{:016x}", key); }

VkPipelineCache create(VkDevice device, const std::vector<std::byte>& bytes) {
  auto info = vk_struct<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  info.initialDataSize = bytes.size();
  info.pInitialData = bytes.data();
  VkPipelineCache cache = VK_NULL_HANDLE;
  return vkCreatePipelineCache(device, &info, nullptr, &cache) == VK_SUCCESS ? cache : VK_NULL_HANDLE;
}

std::vector<std::byte> data_of(VkDevice device, VkPipelineCache cache) {
  size_t size = 0;
  if (vkGetPipelineCacheData(device, cache, &size, nullptr) != VK_SUCCESS) return {};
  std::vector<std::byte> bytes(size);
  if (vkGetPipelineCacheData(device, cache, &size, bytes.data()) != VK_SUCCESS) return {};
  bytes.resize(size);
  return bytes;
}

}  // namespace

PipelineCache::PipelineCache(VkPhysicalDevice physical, VkDevice device) : device_(device), key_(key_of(physical)) {
  const std::vector<std::byte> bytes = load_cached_blob(name_of(key_), key_).value_or(std::vector<std::byte>{});
  handle_ = create(device, bytes);
  if (handle_) {
    loaded_bytes_ = bytes.size();
    loaded_checksum_ = checksum_of(bytes.data(), bytes.size());
  } else {
    handle_ = create(device, {});
    check(handle_ ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY, "vkCreatePipelineCache");
  }
}

PipelineCache::~PipelineCache() {
  const std::vector<std::byte> mine = data_of(device_, handle_);
  if (!mine.empty() && checksum_of(mine.data(), mine.size()) != loaded_checksum_) {
    // What another program has stored since this one began stays.
    const auto theirs = load_cached_blob(name_of(key_), key_);
    if (theirs && checksum_of(theirs->data(), theirs->size()) != loaded_checksum_)
      if (const VkPipelineCache other = create(device_, *theirs)) {
        vkMergePipelineCaches(device_, handle_, 1, &other);
        vkDestroyPipelineCache(device_, other, nullptr);
      }
    store_cached_blob(name_of(key_), key_, data_of(device_, handle_));
  }
  vkDestroyPipelineCache(device_, handle_, nullptr);
}

}  // namespace nepho::gpu
