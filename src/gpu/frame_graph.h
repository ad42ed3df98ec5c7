#pragma once
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gpu/device.h"

namespace nepho {

namespace gpu {
class Commands;
class GraphExecutor;
}  // namespace gpu

/// Handles inside one FrameGraph.
struct ImageRef {
  uint32_t index = ~0u;
  explicit operator bool() const { return index != ~0u; }
  bool operator==(const ImageRef&) const = default;
};
struct BufferRef {
  uint32_t index = ~0u;
  explicit operator bool() const { return index != ~0u; }
  bool operator==(const BufferRef&) const = default;
};

/// How a pass touches a resource; stage, access and layout follow (frame_graph_compile.cpp).
enum class Access {
  sampled,
  storage_read,
  storage_write,
  storage_read_write,
  uniform,
  color_attachment,
  depth_attachment,
  index_buffer,
  indirect,
  transfer_source,
  transfer_target,
};

/// One resource of a graph: transient (created by it), or imported (owned by the caller).
struct GraphResource {
  std::string name;
  bool is_image = true;
  ImageDesc image;
  BufferDesc buffer;
  const gpu::Image* imported_image = nullptr;
  const gpu::Buffer* imported_buffer = nullptr;
  bool kept = false;                ///< an output: never culled, readable after the run
  bool history = false;             ///< contents last until the next frame
  std::vector<std::byte> contents;  ///< constants: uploaded before the frame
};

struct GraphUse {
  uint32_t resource = 0;
  Access access = Access::sampled;
  std::string binding = {};  ///< name in the shader; empty for attachments and copies
  Sampler sampler = Sampler::linear_clamp;
  bool previous = false;  ///< last frame's contents of a history resource
  bool clear = false;     ///< attachments: cleared before the pass to clear_value
  float clear_value[4] = {0, 0, 0, 0};
};

struct GraphPass {
  std::string name;
  std::vector<GraphUse> uses;
  bool raster = false;      ///< has attachments
  bool has_effect = false;  ///< never culled
  std::function<void(gpu::Commands&)> record;
};

/// A frame as data: resources, and passes that declare what they read, write and keep from the last frame. Nothing here
/// needs a device. Barriers, lifetimes, culling, debug names and GPU timings follow from the declaration.
///
/// Every declared use has the name of the shader variable that it is bound to:
///   graph.pass("clouds.march").sample("depth_tex", in.depth).write("out_radiance", out.radiance).record(...)
class FrameGraph {
 public:
  class PassBuilder {
   public:
    /// Texture reads (sampler2D, sampler3D, samplerCube, sampler2DArray by the image).
    PassBuilder& sample(const std::string& binding, ImageRef image, Sampler sampler = Sampler::linear_clamp);
    /// Last frame's contents; zero on the first frame or after its size changed.
    PassBuilder& sample_history(const std::string& binding, ImageRef image, Sampler sampler = Sampler::linear_clamp);
    PassBuilder& read(const std::string& binding, ImageRef image);        ///< storage image, read only
    PassBuilder& write(const std::string& binding, ImageRef image);       ///< storage image, write only
    PassBuilder& read_write(const std::string& binding, ImageRef image);  ///< storage image
    PassBuilder& uniform(const std::string& binding, BufferRef buffer);
    PassBuilder& read(const std::string& binding, BufferRef buffer);  ///< storage buffer
    PassBuilder& write(const std::string& binding, BufferRef buffer);
    PassBuilder& read_write(const std::string& binding, BufferRef buffer);
    PassBuilder& fill(const std::string& name, ImageRef image);  ///< for Commands::fill(name)
    PassBuilder& zero(const std::string& name, BufferRef buffer);  ///< for Commands::zero(name)
    PassBuilder& index_buffer(BufferRef buffer);
    PassBuilder& indirect(BufferRef buffer);  ///< holds group counts, see Commands::dispatch_indirect
    /// Attachments in order; cleared first. The pass becomes a raster pass.
    PassBuilder& color(ImageRef image, float r = 0, float g = 0, float b = 0, float a = 0);
    PassBuilder& depth(ImageRef image, float clear = 0.0f);
    PassBuilder& effect();  ///< never culled
    void record(std::function<void(gpu::Commands&)> record);

   private:
    friend class FrameGraph;
    PassBuilder(FrameGraph& graph, size_t pass) : graph_(graph), pass_(pass) {}
    PassBuilder& use(GraphUse use);
    FrameGraph& graph_;
    size_t pass_;
  };

  ImageRef create(const std::string& name, const ImageDesc& desc);
  /// As create, but its contents last until the next frame run by the same executor (see sample_history).
  ImageRef create_history(const std::string& name, const ImageDesc& desc);
  BufferRef create_buffer(const std::string& name, uint64_t size_bytes);
  ImageRef import(const gpu::Image& image);
  BufferRef import(const gpu::Buffer& buffer);
  /// A read-only buffer with these bytes for this frame.
  BufferRef constants(const std::string& name, const void* data, size_t size_bytes);
  template <typename T>
  BufferRef constants(const std::string& name, const T& value) {
    return constants(name, &value, sizeof(T));
  }
  template <typename T>
  BufferRef constants(const std::string& name, const std::vector<T>& values) {
    return constants(name, values.data(), values.size() * sizeof(T));
  }
  PassBuilder pass(const std::string& name);
  void keep(ImageRef image) { resources_[image.index].kept = true; }
  void keep(BufferRef buffer) { resources_[buffer.index].kept = true; }
  const ImageDesc& desc(ImageRef image) const { return resources_[image.index].image; }

  const std::vector<GraphResource>& resources() const { return resources_; }
  const std::vector<GraphPass>& passes() const { return passes_; }

 private:
  std::vector<GraphResource> resources_;
  std::vector<GraphPass> passes_;
};

}  // namespace nepho
