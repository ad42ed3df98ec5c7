#pragma once
#include <vulkan/vulkan_core.h>

#include "base/error.h"
#include "gpu/types.h"

namespace nepho::gpu {

VkFormat vk_format(Format format);
const char* vk_result_name(VkResult result);

/// A Vulkan structure of zeros with its type and chain filled in.
template <typename T>
T vk_struct(VkStructureType type, void* next = nullptr) {
  T t{};
  t.sType = type;
  t.pNext = next;
  return t;
}

/// Throws Error(failure) naming the call unless it succeeded. Running out of memory says so.
inline void check(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  throw fail(ErrorKind::failure, "{} failed: {}", call, vk_result_name(result));
}

}  // namespace nepho::gpu
