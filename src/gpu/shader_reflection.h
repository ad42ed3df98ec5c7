#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace nepho::gpu {

enum class BindingKind { sampled_image, storage_image, uniform_buffer, storage_buffer };

struct ShaderBinding {
  std::string name;  ///< the GLSL variable, or the block name where the instance has none
  uint32_t binding = 0;
  BindingKind kind = BindingKind::sampled_image;
  uint32_t count = 1;  ///< array length
};

/// What a SPIR-V module asks for. All bindings are in descriptor set 0.
struct ShaderReflection {
  std::vector<ShaderBinding> bindings;
  uint32_t push_constant_bytes = 0;
  uint32_t group_size[3] = {1, 1, 1};  ///< compute only
  const ShaderBinding* find(const std::string& name) const;
};

/// Reads bindings, push constants and workgroup size out of SPIR-V words. Throws Error(failure) on malformed input.
ShaderReflection reflect(std::span<const uint32_t> spirv);

/// The union of two stages. Throws Error(failure) when they disagree on a binding.
ShaderReflection merge(const ShaderReflection& a, const ShaderReflection& b);

}  // namespace nepho::gpu
