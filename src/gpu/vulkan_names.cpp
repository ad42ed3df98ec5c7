#include "gpu/vulkan_names.h"

namespace nepho::gpu {

VkFormat vk_format(Format format) {
  switch (format) {
    case Format::undefined:
      return VK_FORMAT_UNDEFINED;
    case Format::r8:
      return VK_FORMAT_R8_UNORM;
    case Format::rg8:
      return VK_FORMAT_R8G8_UNORM;
    case Format::rgba8:
      return VK_FORMAT_R8G8B8A8_UNORM;
    case Format::rgba8_srgb:
      return VK_FORMAT_R8G8B8A8_SRGB;
    case Format::r16:
      return VK_FORMAT_R16_UNORM;
    case Format::rg16:
      return VK_FORMAT_R16G16_UNORM;
    case Format::rgba16:
      return VK_FORMAT_R16G16B16A16_UNORM;
    case Format::rg16_snorm:
      return VK_FORMAT_R16G16_SNORM;
    case Format::r16f:
      return VK_FORMAT_R16_SFLOAT;
    case Format::rg16f:
      return VK_FORMAT_R16G16_SFLOAT;
    case Format::rgba16f:
      return VK_FORMAT_R16G16B16A16_SFLOAT;
    case Format::r32f:
      return VK_FORMAT_R32_SFLOAT;
    case Format::rg32f:
      return VK_FORMAT_R32G32_SFLOAT;
    case Format::rgba32f:
      return VK_FORMAT_R32G32B32A32_SFLOAT;
    case Format::r32u:
      return VK_FORMAT_R32_UINT;
    case Format::rg32u:
      return VK_FORMAT_R32G32_UINT;
    case Format::rgba32u:
      return VK_FORMAT_R32G32B32A32_UINT;
    case Format::d32f:
      return VK_FORMAT_D32_SFLOAT;
  }
  return VK_FORMAT_UNDEFINED;
}

const char* vk_result_name(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialization failed";
    case VK_ERROR_DEVICE_LOST:
      return "the device was lost";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "a layer is not installed";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "an extension is absent";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "a feature is absent";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no Vulkan driver";
    case VK_ERROR_TOO_MANY_OBJECTS:
      return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      return "format not supported";
    case VK_TIMEOUT:
      return "timeout";
    default:
      return "Vulkan error";
  }
}

}  // namespace nepho::gpu
