#include "gpu/device.h"

#include <vulkan/vulkan.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "base/log.h"
#include "gpu/pipeline_cache.h"
#include "gpu/vulkan_names.h"

namespace nepho::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool has_layer(const char* name) {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [&](const VkLayerProperties& l) { return std::strcmp(l.layerName, name) == 0; });
}

bool has_instance_extension(const char* name) {
  uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

std::string version_text(uint32_t v) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(v), VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
}

/// The Vulkan features that every pass relies on.
struct Features {
  VkPhysicalDeviceVulkan13Features v13 =
      vk_struct<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  VkPhysicalDeviceVulkan12Features v12 =
      vk_struct<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  VkPhysicalDeviceFeatures2 core = vk_struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  Features() {
    v12.pNext = &v13;
    core.pNext = &v12;
  }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

VkInstance make_instance(bool validation, bool debug_utils, VkDebugUtilsMessengerCreateInfoEXT* messenger) {
  auto app = vk_struct<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  app.pApplicationName = "nephoscope";
  app.apiVersion = VK_API_VERSION_1_3;
  auto info = vk_struct<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pApplicationInfo = &app;
  std::vector<const char*> extensions;
  if (debug_utils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  auto features = vk_struct<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;
  if (validation) {
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    features.pNext = messenger;
    info.pNext = &features;
  }
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result != VK_SUCCESS)
    throw fail(ErrorKind::device, "no usable Vulkan device: {}; install a driver, for example mesa-vulkan-drivers",
               vk_result_name(result));
  return instance;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
  uint32_t count = 0;
  if (vkEnumeratePhysicalDevices(instance, &count, nullptr) != VK_SUCCESS) return {};
  std::vector<VkPhysicalDevice> all(count);
  if (count > 0 && vkEnumeratePhysicalDevices(instance, &count, all.data()) < 0) return {};
  return all;
}

bool has_device_extension(VkPhysicalDevice physical, const char* name) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

int general_queue_family(VkPhysicalDevice physical) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  for (uint32_t i = 0; i < count; ++i) {
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    if ((families[i].queueFlags & wanted) == wanted && families[i].timestampValidBits > 0) return static_cast<int>(i);
  }
  return -1;
}

DeviceInfo describe(VkPhysicalDevice physical, uint32_t index) {
  auto driver = vk_struct<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  auto properties = vk_struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver);
  vkGetPhysicalDeviceProperties2(physical, &properties);
  DeviceInfo info;
  info.index = index;
  info.name = properties.properties.deviceName;
  info.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  info.api_version = version_text(properties.properties.apiVersion);
  info.is_software = properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  std::vector<std::string> missing;
  if (properties.properties.apiVersion < VK_API_VERSION_1_3) {
    missing.push_back("Vulkan 1.3");
  } else {
    Features f;
    vkGetPhysicalDeviceFeatures2(physical, &f.core);
    if (!f.v13.dynamicRendering) missing.push_back("dynamicRendering");
    if (!f.v13.synchronization2) missing.push_back("synchronization2");
    if (!f.v13.maintenance4) missing.push_back("maintenance4");
    if (!f.v12.scalarBlockLayout) missing.push_back("scalarBlockLayout");
    if (!has_device_extension(physical, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME))
      missing.push_back("VK_KHR_push_descriptor");
    if (general_queue_family(physical) < 0) missing.push_back("a graphics and compute queue with timestamps");
  }
  info.usable = missing.empty();
  info.why_not = info.usable ? "" : fmt::format("lacks {}", fmt::join(missing, ", "));
  return info;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string names_of(const std::vector<DeviceInfo>& devices) {
  std::vector<std::string> names;
  for (const DeviceInfo& d : devices)
    names.push_back(d.usable ? fmt::format("{}: {}", d.index, d.name)
                             : fmt::format("{}: {} ({})", d.index, d.name, d.why_not));
  return fmt::format("{}", fmt::join(names, "; "));
}

/// The index of the device to use. A real GPU first, else a software one; or the one that is asked for.
uint32_t choose(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
  if (devices.empty())
    throw Error(ErrorKind::device,
                "no usable Vulkan device: no driver found; install one, for example mesa-vulkan-drivers");
  if (!wanted.empty()) {
    const bool is_index = std::all_of(wanted.begin(), wanted.end(), [](unsigned char c) { return std::isdigit(c); });
    for (const DeviceInfo& d : devices) {
      const bool match =
          is_index ? std::to_string(d.index) == wanted : lower(d.name).find(lower(wanted)) != std::string::npos;
      if (!match) continue;
      if (!d.usable) throw fail(ErrorKind::device, "Vulkan device '{}' {}", d.name, d.why_not);
      return d.index;
    }
    throw fail(ErrorKind::device, "no Vulkan device matches '{}'; found {}", wanted, names_of(devices));
  }
  for (const bool software : {false, true})
    for (const DeviceInfo& d : devices)
      if (d.usable && d.is_software == software) return d.index;
  throw fail(ErrorKind::device, "no usable Vulkan device; found {}", names_of(devices));
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> out;
  VkInstance instance = VK_NULL_HANDLE;
  try {
    instance = make_instance(false, false, nullptr);
  } catch (const Error&) {
    return out;
  }
  uint32_t index = 0;
  for (VkPhysicalDevice physical : physical_devices(instance)) out.push_back(describe(physical, index++));
  vkDestroyInstance(instance, nullptr);
  return out;
}

VKAPI_ATTR VkBool32 VKAPI_CALL Device::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  auto* device = static_cast<Device*>(user);
  const std::lock_guard lock(device->messages_mutex_);
  device->messages_.emplace_back(data->pMessage);
  return VK_FALSE;
}

Device::Device(const DeviceOptions& options) {
  validation_ = options.validation;
  if (validation_ && !has_layer(kValidationLayer))
    throw Error(ErrorKind::device, "the Khronos validation layer is not installed; install vulkan-validationlayers");
  debug_utils_ = validation_ || has_instance_extension(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  auto messenger =
      vk_struct<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = &Device::on_message;
  messenger.pUserData = this;
  instance_ = make_instance(validation_, debug_utils_, validation_ ? &messenger : nullptr);
  try {
    if (validation_) {
      const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
      check(create(instance_, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
    }
    const std::vector<VkPhysicalDevice> physicals = physical_devices(instance_);
    std::vector<DeviceInfo> infos;
    for (uint32_t i = 0; i < physicals.size(); ++i) infos.push_back(describe(physicals[i], i));
    const uint32_t chosen = choose(infos, options.device);
    physical_ = physicals[chosen];
    info_ = infos[chosen];
    queue_family_ = static_cast<uint32_t>(general_queue_family(physical_));
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical_, &properties);
    timestamp_period_ns_ = properties.limits.timestampPeriod;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_types_);

    const float priority = 1.0f;
    auto queue = vk_struct<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    Features wanted;
    wanted.v13.dynamicRendering = VK_TRUE;
    wanted.v13.synchronization2 = VK_TRUE;
    wanted.v13.maintenance4 = VK_TRUE;  // glslang states workgroup sizes by LocalSizeId
    wanted.v12.scalarBlockLayout = VK_TRUE;
    const char* extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
    auto create = vk_struct<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &wanted.core);
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.enabledExtensionCount = 1;
    create.ppEnabledExtensionNames = extensions;
    const VkResult made = vkCreateDevice(physical_, &create, nullptr, &device_);
    if (made != VK_SUCCESS)
      throw fail(ErrorKind::device, "Vulkan device '{}' cannot be opened: {}", info_.name, vk_result_name(made));
  } catch (...) {
    if (messenger_)
      reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"))(instance_, messenger_, nullptr);
    vkDestroyInstance(instance_, nullptr);
    throw;
  }
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
  push_descriptor_set =
      reinterpret_cast<PFN_vkCmdPushDescriptorSetKHR>(vkGetDeviceProcAddr(device_, "vkCmdPushDescriptorSetKHR"));
  if (debug_utils_) {
    set_object_name_ = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetDeviceProcAddr(device_, "vkSetDebugUtilsObjectNameEXT"));
    cmd_begin_label_ = reinterpret_cast<PFN_vkCmdBeginDebugUtilsLabelEXT>(
        vkGetDeviceProcAddr(device_, "vkCmdBeginDebugUtilsLabelEXT"));
    cmd_end_label_ =
        reinterpret_cast<PFN_vkCmdEndDebugUtilsLabelEXT>(vkGetDeviceProcAddr(device_, "vkCmdEndDebugUtilsLabelEXT"));
  }
  auto pool = vk_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queue_family_;
  check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
  auto fence = vk_struct<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  check(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
  pipeline_cache_ = std::make_unique<PipelineCache>(physical_, device_);
  for (const Sampler kind :
       {Sampler::linear_clamp, Sampler::linear_repeat, Sampler::nearest_clamp, Sampler::linear_repeat_u}) {
    auto s = vk_struct<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
    const bool nearest = kind == Sampler::nearest_clamp;
    const auto address = [&](bool repeat) {
      return repeat ? VK_SAMPLER_ADDRESS_MODE_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    };
    s.magFilter = s.minFilter = nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    s.mipmapMode = nearest ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
    s.addressModeU = address(kind == Sampler::linear_repeat || kind == Sampler::linear_repeat_u);
    s.addressModeV = s.addressModeW = address(kind == Sampler::linear_repeat);
    s.maxLod = VK_LOD_CLAMP_NONE;
    check(vkCreateSampler(device_, &s, nullptr, &samplers_[static_cast<size_t>(kind)]), "vkCreateSampler");
  }
}

Device::~Device() {
  wait_idle();
  for (VkSampler sampler : samplers_) vkDestroySampler(device_, sampler, nullptr);
  pipeline_cache_.reset();
  vkDestroyFence(device_, fence_, nullptr);
  vkDestroyCommandPool(device_, pool_, nullptr);
  vkDestroyDevice(device_, nullptr);
  if (messenger_)
    reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"))(instance_, messenger_, nullptr);
  vkDestroyInstance(instance_, nullptr);
}

VkPipelineCache Device::pipeline_cache() const { return pipeline_cache_->handle(); }

void Device::wait_idle() {
  if (device_) vkDeviceWaitIdle(device_);
}

std::vector<std::string> Device::take_validation_messages() {
  const std::lock_guard lock(messages_mutex_);
  return std::exchange(messages_, {});
}

void Device::set_name(VkObjectType type, uint64_t handle, const std::string& name) const {
  if (!set_object_name_ || name.empty()) return;
  auto info = vk_struct<VkDebugUtilsObjectNameInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
  info.objectType = type;
  info.objectHandle = handle;
  info.pObjectName = name.c_str();
  set_object_name_(device_, &info);
}

void Device::begin_label(VkCommandBuffer cmd, const std::string& name) const {
  if (!cmd_begin_label_) return;
  auto label = vk_struct<VkDebugUtilsLabelEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
  label.pLabelName = name.c_str();
  cmd_begin_label_(cmd, &label);
}

void Device::end_label(VkCommandBuffer cmd) const {
  if (cmd_end_label_) cmd_end_label_(cmd);
}

VkCommandBuffer Device::begin_commands() {
  auto info = vk_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  info.commandPool = pool_;
  info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  info.commandBufferCount = 1;
  VkCommandBuffer cmd = VK_NULL_HANDLE;
  check(vkAllocateCommandBuffers(device_, &info, &cmd), "vkAllocateCommandBuffers");
  auto begin = vk_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");
  return cmd;
}

void Device::end_commands_and_wait(VkCommandBuffer cmd) {
  check(vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
  auto buffer = vk_struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  buffer.commandBuffer = cmd;
  auto submit = vk_struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &buffer;
  check(vkQueueSubmit2(queue_, 1, &submit, fence_), "vkQueueSubmit2");
  check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  check(vkResetFences(device_, 1, &fence_), "vkResetFences");
  vkFreeCommandBuffers(device_, pool_, 1, &cmd);
}

}  // namespace nepho::gpu
