#pragma once
#include <cstring>
#include <map>

#include "gpu/frame_graph.h"
#include "gpu/pipeline.h"

namespace nepho::gpu {

/// Records one pass. Bindings come from the pass's declaration, matched to the pipeline's shader by name; a binding
/// that the shader has and the pass lacks is an Error(failure) that names both.
class Commands {
 public:
  /// Views one mip of a declared image under the binding's name in the next bind() (storage or sampled). For pyramids.
  Commands& mip(const std::string& binding, uint32_t level);
  Commands& bind(const Pipeline& pipeline);
  template <typename T>
  Commands& push(const T& constants) {
    return push_bytes(&constants, sizeof(T));
  }
  Commands& push_bytes(const void* data, size_t size_bytes);
  /// Threads, not groups: divided by the workgroup size that the SPIR-V states.
  Commands& dispatch_threads(uint32_t x, uint32_t y = 1, uint32_t z = 1);
  /// As many groups as the pass's `indirect` buffer says: three uint at its start.
  Commands& dispatch_indirect();
  Commands& draw_indexed(uint32_t index_count, uint32_t first_index = 0, uint32_t instance_count = 1,
                         uint32_t first_instance = 0);
  Commands& draw(uint32_t vertex_count, uint32_t instance_count = 1);
  /// Fills a buffer that the pass declares with PassBuilder::zero().
  Commands& zero(const std::string& name);
  /// Fills a colour image that the pass declares with PassBuilder::fill().
  Commands& fill(const std::string& name, float r, float g = 0, float b = 0, float a = 0);
  /// Makes writes of earlier dispatches of this same pass visible to later ones.
  Commands& barrier();
  VkCommandBuffer handle() const { return cmd_; }

 private:
  friend class GraphExecutor;
  struct Bound {
    const GraphUse* use = nullptr;
    const Image* image = nullptr;
    const Buffer* buffer = nullptr;
  };
  Device* device_ = nullptr;
  VkCommandBuffer cmd_ = VK_NULL_HANDLE;
  const GraphPass* pass_ = nullptr;
  std::vector<Bound> bound_;
  const Buffer* indirect_ = nullptr;
  std::map<std::string, uint32_t> mips_;
  const Pipeline* pipeline_ = nullptr;
};

}  // namespace nepho::gpu
