#pragma once
#include <array>
#include <glm/vec4.hpp>
#include <vector>

#include "clouds/volume_tools.h"
#include "gpu/frame_graph.h"
#include "scene/cloud_params.h"

namespace nepho {

/// The tileable noises of the clouds, made on the GPU at first and then kept in cache_dir(), or read from files. All
/// volumes have full mips. Values are standard deviations from the mean, -4..4 as 0..1.
/// - field, 128^3 rgba16: four independent normal fields, fractal: octaves of 4..64 cycles a side.
/// - cells, 128^3 rg16: r rounded cells with creases (8 to 16 a side), g a finer fractal (8..64 cycles); both normal.
/// - shape, 128^3 r16: Perlin-Worley billows, 8..70 cycles; normal.
/// - detail, 32^3 r16: Worley, 4 and 8 cycles; normal.
/// - turbulence, 64^3 rgba16: xyz a divergence-free vector (curl of noise, 4..16 cycles), each component of variance 1.
/// - blue, 64 x 64 x 16 r8 (a 2D array): spatiotemporal blue noise, uniform over 0..255 within every slice.
class CloudNoise {
 public:
  /// Throws Error(input) for a file that is no such texture.
  CloudNoise(gpu::Device& device, const CloudNoiseParams& params = {});
  struct Refs {
    ImageRef field, cells, shape, detail, turbulence, blue;
  };
  Refs import_into(FrameGraph& graph) const;

  /// What is left of a noise's variance at a level of detail: shared::variance_left(lod, start, per_lod), fitted to its
  /// mips, as they are read linearly between texels.
  struct Fade {
    float start = 0.0f, per_lod = 1.0f;
  };
  struct Fades {
    Fade field, cells_round, cells_fractal, shape, detail;
  };
  const Fades& fades() const { return fades_; }
  /// Measured, mip by mip, in the order of Fades: shares of mip 0's.
  const std::array<std::vector<float>, 5>& variances() const { return variances_; }
  /// Texels a side, for texel sizes; of files as they are.
  uint32_t shape_size() const;
  uint32_t detail_size() const;
  uint32_t turbulence_size() const;
  static constexpr uint32_t kFieldSize = 128, kCellsSize = 128;

  const gpu::Image& field() const { return field_; }
  const gpu::Image& cells() const { return cells_; }
  const gpu::Image& shape() const { return shape_; }
  const gpu::Image& detail() const { return detail_; }
  const gpu::Image& turbulence() const { return turbulence_; }
  const gpu::Image& blue() const { return blue_; }

 private:
  gpu::Image field_, cells_, shape_, detail_, turbulence_, blue_;
  Fades fades_;
  std::array<std::vector<float>, 5> variances_;
};

}  // namespace nepho
