#pragma once
#include <array>
#include <glm/vec4.hpp>
#include <vector>

#include "gpu/frame_graph.h"

namespace nepho {

/// The tileable noise volumes of the clouds, made on the GPU at first and then kept in cache_dir(): `field` 128^3
/// (fractal field, cells), `shape` 128^3 and `detail` 32^3 (billows), all with mips. Values are standard deviations
/// from the mean, -4..4 as 0..1; `field` has a normal distribution.
class CloudNoise {
 public:
  explicit CloudNoise(gpu::Device& device);
  struct Refs {
    ImageRef field, shape, detail;
  };
  Refs import_into(FrameGraph& graph) const {
    return {graph.import(field_), graph.import(shape_), graph.import(detail_)};
  }
  /// Variance that mip 0..9 keeps of field.r, field.g, shape and detail; 1 at mip 0, 0 beyond the last.
  const std::array<glm::vec4, 10>& variance() const { return variance_; }
  /// shared::variance_left() fitted to variance(), component by component.
  glm::vec4 fade_start() const { return fade_start_; }
  glm::vec4 fade_per_lod() const { return fade_per_lod_; }
  const gpu::Image& field() const { return field_; }
  const gpu::Image& shape() const { return shape_; }
  const gpu::Image& detail() const { return detail_; }

 private:
  gpu::Image field_, shape_, detail_;
  std::array<glm::vec4, 10> variance_{};
  glm::vec4 fade_start_{0.0f}, fade_per_lod_{1.0f};
};

/// One channel of a cubic volume brought to mean 0 and variance 1; `gaussian` gives it a normal distribution by rank.
void normalise_volume(std::vector<float>& values, bool gaussian);

/// The next mip of a cubic volume of `size` texels a side: means of 2 x 2 x 2.
std::vector<float> half_volume(const std::vector<float>& values, uint32_t size);

}  // namespace nepho
