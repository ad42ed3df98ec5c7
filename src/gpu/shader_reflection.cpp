#include "gpu/shader_reflection.h"

#include <spirv_cross_c.h>

#include <algorithm>
#include <memory>

#include "base/error.h"

namespace nepho::gpu {

const ShaderBinding* ShaderReflection::find(const std::string& name) const {
  for (const ShaderBinding& b : bindings)
    if (b.name == name) return &b;
  return nullptr;
}

namespace {
void require(spvc_result result, spvc_context context) {
  if (result != SPVC_SUCCESS)
    throw fail(ErrorKind::failure, "shader reflection: {}", spvc_context_get_last_error_string(context));
}
}  // namespace

ShaderReflection reflect(std::span<const uint32_t> spirv) {
  spvc_context raw = nullptr;
  if (spvc_context_create(&raw) != SPVC_SUCCESS) throw Error(ErrorKind::failure, "shader reflection: out of memory");
  const std::unique_ptr<spvc_context_s, void (*)(spvc_context)> context(raw, spvc_context_destroy);
  spvc_parsed_ir ir = nullptr;
  require(spvc_context_parse_spirv(raw, spirv.data(), spirv.size(), &ir), raw);
  spvc_compiler compiler = nullptr;
  require(spvc_context_create_compiler(raw, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler), raw);
  // Only what the entry point uses: unused bindings of an included header need not be declared by the pass.
  spvc_set active = nullptr;
  require(spvc_compiler_get_active_interface_variables(compiler, &active), raw);
  spvc_resources resources = nullptr;
  require(spvc_compiler_create_shader_resources_for_active_variables(compiler, &resources, active), raw);

  ShaderReflection out;
  const std::pair<spvc_resource_type, BindingKind> kinds[] = {
      {SPVC_RESOURCE_TYPE_SAMPLED_IMAGE, BindingKind::sampled_image},
      {SPVC_RESOURCE_TYPE_STORAGE_IMAGE, BindingKind::storage_image},
      {SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, BindingKind::uniform_buffer},
      {SPVC_RESOURCE_TYPE_STORAGE_BUFFER, BindingKind::storage_buffer}};
  for (const auto& [type, kind] : kinds) {
    const spvc_reflected_resource* list = nullptr;
    size_t count = 0;
    require(spvc_resources_get_resource_list_for_type(resources, type, &list, &count), raw);
    for (size_t i = 0; i < count; ++i) {
      ShaderBinding binding;
      // For blocks, the instance name; a block without one gets its block name.
      const char* variable = spvc_compiler_get_name(compiler, list[i].id);
      binding.name = variable && *variable ? variable : list[i].name;
      binding.binding = spvc_compiler_get_decoration(compiler, list[i].id, SpvDecorationBinding);
      binding.kind = kind;
      const spvc_type handle = spvc_compiler_get_type_handle(compiler, list[i].type_id);
      if (spvc_type_get_num_array_dimensions(handle) > 0) binding.count = spvc_type_get_array_dimension(handle, 0);
      out.bindings.push_back(binding);
    }
  }
  std::sort(out.bindings.begin(), out.bindings.end(),
            [](const ShaderBinding& a, const ShaderBinding& b) { return a.binding < b.binding; });

  const spvc_reflected_resource* list = nullptr;
  size_t count = 0;
  require(spvc_resources_get_resource_list_for_type(resources, SPVC_RESOURCE_TYPE_PUSH_CONSTANT, &list, &count), raw);
  if (count > 0) {
    size_t size = 0;
    const spvc_type type = spvc_compiler_get_type_handle(compiler, list[0].base_type_id);
    require(spvc_compiler_get_declared_struct_size(compiler, type, &size), raw);
    out.push_constant_bytes = static_cast<uint32_t>(size);
  }
  if (spvc_compiler_get_execution_model(compiler) == SpvExecutionModelGLCompute)
    for (unsigned i = 0; i < 3; ++i)
      out.group_size[i] = spvc_compiler_get_execution_mode_argument_by_index(compiler, SpvExecutionModeLocalSize, i);
  return out;
}

ShaderReflection merge(const ShaderReflection& a, const ShaderReflection& b) {
  ShaderReflection out = a;
  for (const ShaderBinding& binding : b.bindings) {
    bool known = false;
    for (const ShaderBinding& mine : a.bindings) {
      if (mine.binding != binding.binding) continue;
      if (mine.name != binding.name || mine.kind != binding.kind)
        throw fail(ErrorKind::failure, "shader stages disagree on binding {}: '{}' and '{}'", binding.binding,
                   mine.name, binding.name);
      known = true;
    }
    if (!known) out.bindings.push_back(binding);
  }
  out.push_constant_bytes = std::max(a.push_constant_bytes, b.push_constant_bytes);
  return out;
}

}  // namespace nepho::gpu
