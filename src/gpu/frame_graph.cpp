#include "gpu/frame_graph.h"

#include "base/error.h"

namespace nepho {

ImageRef FrameGraph::create(const std::string& name, const ImageDesc& desc) {
  GraphResource r;
  r.name = name;
  r.image = desc;
  resources_.push_back(std::move(r));
  return {static_cast<uint32_t>(resources_.size() - 1)};
}

ImageRef FrameGraph::create_history(const std::string& name, const ImageDesc& desc) {
  const ImageRef ref = create(name, desc);
  resources_[ref.index].history = true;
  return ref;
}

BufferRef FrameGraph::create_buffer(const std::string& name, uint64_t size_bytes) {
  GraphResource r;
  r.name = name;
  r.is_image = false;
  r.buffer = {size_bytes};
  resources_.push_back(std::move(r));
  return {static_cast<uint32_t>(resources_.size() - 1)};
}

ImageRef FrameGraph::import(const gpu::Image& image) {
  for (uint32_t i = 0; i < resources_.size(); ++i)
    if (resources_[i].imported_image == &image) return {i};
  const ImageRef ref = create(image.name(), image.desc());
  resources_[ref.index].imported_image = &image;
  return ref;
}

BufferRef FrameGraph::import(const gpu::Buffer& buffer) {
  for (uint32_t i = 0; i < resources_.size(); ++i)
    if (resources_[i].imported_buffer == &buffer) return {i};
  const BufferRef ref = create_buffer(buffer.name(), buffer.desc().size_bytes);
  resources_[ref.index].imported_buffer = &buffer;
  return ref;
}

BufferRef FrameGraph::constants(const std::string& name, const void* data, size_t size_bytes) {
  const BufferRef ref = create_buffer(name, size_bytes);
  const auto* bytes = static_cast<const std::byte*>(data);
  resources_[ref.index].contents.assign(bytes, bytes + size_bytes);
  return ref;
}

FrameGraph::PassBuilder FrameGraph::pass(const std::string& name) {
  GraphPass p;
  p.name = name;
  passes_.push_back(std::move(p));
  return {*this, passes_.size() - 1};
}

using Builder = FrameGraph::PassBuilder;

Builder& Builder::use(GraphUse use) {
  NEPHO_ASSERT_OP(use.resource, <, graph_.resources_.size());  // an ImageRef of another graph, or an empty one
  graph_.passes_[pass_].uses.push_back(std::move(use));
  return *this;
}
Builder& Builder::sample(const std::string& binding, ImageRef image, Sampler sampler) {
  return use({.resource = image.index, .access = Access::sampled, .binding = binding, .sampler = sampler});
}
Builder& Builder::sample_history(const std::string& binding, ImageRef image, Sampler sampler) {
  NEPHO_ASSERT(graph_.resources_[image.index].history);
  return use(
      {.resource = image.index, .access = Access::sampled, .binding = binding, .sampler = sampler, .previous = true});
}
Builder& Builder::read(const std::string& binding, ImageRef image) {
  return use({.resource = image.index, .access = Access::storage_read, .binding = binding});
}
Builder& Builder::write(const std::string& binding, ImageRef image) {
  return use({.resource = image.index, .access = Access::storage_write, .binding = binding});
}
Builder& Builder::read_write(const std::string& binding, ImageRef image) {
  return use({.resource = image.index, .access = Access::storage_read_write, .binding = binding});
}
Builder& Builder::uniform(const std::string& binding, BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::uniform, .binding = binding});
}
Builder& Builder::read(const std::string& binding, BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::storage_read, .binding = binding});
}
Builder& Builder::write(const std::string& binding, BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::storage_write, .binding = binding});
}
Builder& Builder::read_write(const std::string& binding, BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::storage_read_write, .binding = binding});
}
Builder& Builder::fill(const std::string& name, ImageRef image) {
  return use({.resource = image.index, .access = Access::transfer_target, .binding = name});
}
Builder& Builder::zero(const std::string& name, BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::transfer_target, .binding = name});
}
Builder& Builder::indirect(BufferRef buffer) { return use({.resource = buffer.index, .access = Access::indirect}); }
Builder& Builder::index_buffer(BufferRef buffer) {
  return use({.resource = buffer.index, .access = Access::index_buffer});
}
Builder& Builder::color(ImageRef image, float r, float g, float b, float a) {
  graph_.passes_[pass_].raster = true;
  return use({.resource = image.index, .access = Access::color_attachment, .clear = true, .clear_value = {r, g, b, a}});
}
Builder& Builder::depth(ImageRef image, float clear) {
  graph_.passes_[pass_].raster = true;
  return use(
      {.resource = image.index, .access = Access::depth_attachment, .clear = true, .clear_value = {clear, 0, 0, 0}});
}
Builder& Builder::effect() {
  graph_.passes_[pass_].has_effect = true;
  return *this;
}
void Builder::record(std::function<void(gpu::Commands&)> record) { graph_.passes_[pass_].record = std::move(record); }

}  // namespace nepho
