#pragma once
#include <optional>
#include <vector>

#include "clouds/cloud_density.h"
#include "geo/geodetic.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Evaluates the clouds at points, on the GPU, by the very functions that the march uses.
class CloudProbe {
 public:
  CloudProbe(gpu::Device& device, const Clouds& clouds);

  /// A point, and the camera through which it is looked at: noise coordinates are relative to it.
  struct Case {
    Geodetic point;
    std::optional<Geodetic> camera;  ///< without: at the point itself, 2 m aside
    double time_s = 0.0;             ///< seconds since 2000-01-01T12:00Z, as FrameInfo::time_s
    double footprint_m = 0.0;        ///< detail smaller than this is averaged; 0: full detail
  };
  struct Weather {
    glm::vec4 coverage{0.0f};  ///< of the channels R, G, B, A, refined below the map's texels down to some 2 km
    float type = 0.5f;         ///< 0 stratiform, 1 towering
    float base_offset_m = 0.0f;
    float density_factor = 1.0f;
    float precipitation = 0.0f;
  };
  struct Density {
    glm::vec4 density{0.0f};  ///< by layer: 0..density_scale
    float extinction_per_m = 0.0f;
  };
  struct Column {
    glm::vec4 optical_depth{0.0f};  ///< vertical, by layer, mean over the footprint
    float base_m = 0.0f;            ///< lowest and highest cloud above the ellipsoid, m; NaN in a clear column
    float top_m = 0.0f;
  };
  std::vector<Weather> weather(const std::vector<Case>& cases);
  std::vector<Density> density(const std::vector<Case>& cases);
  std::vector<Column> column(const std::vector<Case>& cases);

 private:
  template <typename Answer>
  std::vector<Answer> run(const gpu::ComputePipeline& pipeline, const std::vector<Case>& cases);
  gpu::GraphExecutor executor_;
  const Clouds& clouds_;
  gpu::ComputePipeline weather_, density_, column_;
};

}  // namespace nepho
