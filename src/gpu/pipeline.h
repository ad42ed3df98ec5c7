#pragma once
#include <span>
#include <string>
#include <vector>

#include "gpu/device.h"
#include "gpu/shader_reflection.h"

namespace nepho::gpu {

struct ComputePipelineCreate {
  std::string name;
  std::span<const uint32_t> spirv;
  std::vector<uint32_t> constants = {};  ///< values of the specialisation constants 0, 1, ...
};

/// Raster pipelines pull their vertices from buffers: there is no vertex input state. Reversed Z, depth test
/// GREATER_OR_EQUAL.
struct GraphicsPipelineCreate {
  std::string name;
  std::span<const uint32_t> vertex_spirv;
  std::span<const uint32_t> fragment_spirv;
  std::vector<Format> color_formats;
  Format depth_format = Format::d32f;  ///< undefined: no depth
  bool cull_back = true;               ///< front faces are counter-clockwise seen from outside
};

/// What both kinds share: layouts that follow from the SPIR-V. Bindings are found by their GLSL variable (or block)
/// names.
class Pipeline {
 public:
  Pipeline() = default;
  Pipeline(Pipeline&& other) noexcept { *this = std::move(other); }
  Pipeline& operator=(Pipeline&& other) noexcept;
  ~Pipeline();
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
  const std::string& name() const { return name_; }
  VkPipeline handle() const { return handle_; }
  VkPipelineLayout layout() const { return layout_; }
  VkPipelineBindPoint bind_point() const { return bind_point_; }
  const ShaderReflection& reflection() const { return reflection_; }

 protected:
  void create_layouts(Device& device, VkShaderStageFlags stages);
  Device* device_ = nullptr;
  std::string name_;
  ShaderReflection reflection_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline handle_ = VK_NULL_HANDLE;
  VkPipelineBindPoint bind_point_ = VK_PIPELINE_BIND_POINT_COMPUTE;
};

class ComputePipeline : public Pipeline {
 public:
  ComputePipeline() = default;
  ComputePipeline(Device& device, const ComputePipelineCreate& create);
};

class GraphicsPipeline : public Pipeline {
 public:
  GraphicsPipeline() = default;
  GraphicsPipeline(Device& device, const GraphicsPipelineCreate& create);
};

}  // namespace nepho::gpu
