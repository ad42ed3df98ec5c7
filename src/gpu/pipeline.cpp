#include "gpu/pipeline.h"

#include <array>

#include "gpu/vulkan_names.h"

namespace nepho::gpu {

namespace {
VkDescriptorType descriptor_type(BindingKind kind) {
  switch (kind) {
    case BindingKind::sampled_image:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case BindingKind::storage_image:
      return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    case BindingKind::uniform_buffer:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case BindingKind::storage_buffer:
      return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  }
  return VK_DESCRIPTOR_TYPE_MAX_ENUM;
}

VkShaderModule make_module(const Device& device, std::span<const uint32_t> spirv) {
  auto info = vk_struct<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(device.handle(), &info, nullptr, &module), "vkCreateShaderModule");
  return module;
}
}  // namespace

Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(reflection_, other.reflection_);
  std::swap(set_layout_, other.set_layout_);
  std::swap(layout_, other.layout_);
  std::swap(handle_, other.handle_);
  std::swap(bind_point_, other.bind_point_);
  return *this;
}

Pipeline::~Pipeline() {
  if (!device_) return;
  vkDestroyPipeline(device_->handle(), handle_, nullptr);
  vkDestroyPipelineLayout(device_->handle(), layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_->handle(), set_layout_, nullptr);
}

void Pipeline::create_layouts(Device& device, VkShaderStageFlags stages) {
  device_ = &device;
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const ShaderBinding& b : reflection_.bindings)
    bindings.push_back({b.binding, descriptor_type(b.kind), b.count, stages, nullptr});
  auto set_info = vk_struct<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set_info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
  set_info.bindingCount = static_cast<uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  check(vkCreateDescriptorSetLayout(device.handle(), &set_info, nullptr, &set_layout_), "vkCreateDescriptorSetLayout");
  if (reflection_.push_constant_bytes > 128)
    throw fail(ErrorKind::failure, "pipeline {}: {} bytes of push constants, 128 are portable", name_,
               reflection_.push_constant_bytes);
  const VkPushConstantRange range{stages, 0, (reflection_.push_constant_bytes + 3u) & ~3u};
  auto layout_info = vk_struct<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout_;
  if (range.size > 0) {
    layout_info.pushConstantRangeCount = 1;
    layout_info.pPushConstantRanges = &range;
  }
  check(vkCreatePipelineLayout(device.handle(), &layout_info, nullptr, &layout_), "vkCreatePipelineLayout");
}

ComputePipeline::ComputePipeline(Device& device, const ComputePipelineCreate& create) {
  name_ = create.name;
  reflection_ = reflect(create.spirv);
  bind_point_ = VK_PIPELINE_BIND_POINT_COMPUTE;
  create_layouts(device, VK_SHADER_STAGE_COMPUTE_BIT);
  const VkShaderModule module = make_module(device, create.spirv);
  auto info = vk_struct<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout_;
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t i = 0; i < create.constants.size(); ++i) entries.push_back({i, 4 * i, 4});
  const VkSpecializationInfo constants{static_cast<uint32_t>(entries.size()), entries.data(),
                                       4 * create.constants.size(), create.constants.data()};
  info.stage.pSpecializationInfo = entries.empty() ? nullptr : &constants;
  const VkResult result =
      vkCreateComputePipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &handle_);
  vkDestroyShaderModule(device.handle(), module, nullptr);
  check(result, "vkCreateComputePipelines");
  device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(handle_), name_);
}

GraphicsPipeline::GraphicsPipeline(Device& device, const GraphicsPipelineCreate& create) {
  name_ = create.name;
  reflection_ = merge(reflect(create.vertex_spirv), reflect(create.fragment_spirv));
  bind_point_ = VK_PIPELINE_BIND_POINT_GRAPHICS;
  create_layouts(device, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT);

  const VkShaderModule vertex = make_module(device, create.vertex_spirv);
  const VkShaderModule fragment = make_module(device, create.fragment_spirv);
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  stages[0] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
               nullptr,
               0,
               VK_SHADER_STAGE_VERTEX_BIT,
               vertex,
               "main",
               nullptr};
  stages[1] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
               nullptr,
               0,
               VK_SHADER_STAGE_FRAGMENT_BIT,
               fragment,
               "main",
               nullptr};
  auto input =
      vk_struct<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  auto assembly =
      vk_struct<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  auto viewport = vk_struct<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  auto raster =
      vk_struct<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = create.cull_back ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1.0f;
  auto samples =
      vk_struct<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  auto depth =
      vk_struct<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
  const bool has_depth = create.depth_format != Format::undefined;
  depth.depthTestEnable = has_depth;
  depth.depthWriteEnable = has_depth;
  depth.depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;  // reversed Z
  VkPipelineColorBlendAttachmentState no_blend{};
  no_blend.colorWriteMask =
      VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  const std::vector<VkPipelineColorBlendAttachmentState> blends(create.color_formats.size(), no_blend);
  auto blend = vk_struct<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = static_cast<uint32_t>(blends.size());
  blend.pAttachments = blends.data();
  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamic = vk_struct<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamic.dynamicStateCount = 2;
  dynamic.pDynamicStates = dynamic_states;
  std::vector<VkFormat> formats;
  for (Format f : create.color_formats) formats.push_back(vk_format(f));
  auto rendering = vk_struct<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.colorAttachmentCount = static_cast<uint32_t>(formats.size());
  rendering.pColorAttachmentFormats = formats.data();
  rendering.depthAttachmentFormat = vk_format(create.depth_format);

  auto info = vk_struct<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering);
  info.stageCount = 2;
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout_;
  const VkResult result =
      vkCreateGraphicsPipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &handle_);
  vkDestroyShaderModule(device.handle(), vertex, nullptr);
  vkDestroyShaderModule(device.handle(), fragment, nullptr);
  check(result, "vkCreateGraphicsPipelines");
  device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(handle_), name_);
}

}  // namespace nepho::gpu
