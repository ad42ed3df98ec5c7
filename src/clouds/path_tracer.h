#pragma once
#include <array>
#include <functional>

#include "clouds/cloud_bounds.h"
#include "clouds/cloud_density.h"
#include "clouds/path_shared.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Traces paths through the clouds without bias (shaders/clouds/path_trace.comp, docs/reference.md). It knows nothing
/// of the air: what a path brought home is written as a shared::PathResult each, and whoever calls makes luminance of
/// it.
class PathTracer {
 public:
  enum class Mode : uint32_t {
    picture,  ///< pixels of a frame over its ground, lit by the key light
    furnace,  ///< pixels of a frame; light comes evenly from all sides
    table,    ///< rays of a table; the key light's illuminance is 1, the ground is black
  };
  /// `clouds` must outlive the tracer.
  PathTracer(gpu::Device& device, const Clouds& clouds, Mode mode);

  struct Inputs {
    CloudDensityRefs density;
    const CloudBoundsMap* bounds = nullptr;  ///< made for this frame
    shared::RegionMap ground{};              ///< of the two images below
    ImageRef ground_albedo, ground_height;   ///< as terrain/ground_map.glsl reads them
    // Mode picture; the frame may be finer than the picture (PathPush::subpixels).
    ImageRef surface_depth, surface_albedo, surface_normal;
    ImageRef key;    ///< illuminance of the key light (shaders/render/reference_key.comp)
    BufferRef rays;  ///< mode table: shared::PathRay
  };
  /// Traces push.samples paths for each of push.pixels pixels (or rays), in as many dispatches as the device wants.
  /// Images that the mode does not read may be absent; what `make_inputs` returns is asked for anew for every graph.
  void run(gpu::GraphExecutor& executor, const FrameInfo& frame,
           const std::function<Inputs(FrameGraph&, const FrameInfo&)>& make_inputs, const shared::PathPush& push);
  /// shared::PathResult of the last run(), push.pixels x push.samples.
  const gpu::Buffer& results() const { return results_; }
  /// Of the last run().
  const shared::PathCounts& counts() const { return counts_; }
  double trace_ms() const { return trace_ms_; }  ///< by GPU timestamps

  /// Paths of one dispatch at most: a storage buffer of 128 MiB holds so many results.
  static constexpr uint32_t kMostPaths = (120u << 20) / sizeof(shared::PathResult);

 private:
  const gpu::ComputePipeline& pipeline(uint32_t phases);
  gpu::Device& device_;
  const Clouds& clouds_;
  Mode mode_;
  gpu::Image none_2d_, none_array_;
  gpu::Buffer results_, work_, lanes_;
  std::array<gpu::ComputePipeline, 2> trace_;  ///< by phases - 1
  shared::PathCounts counts_{};
  double trace_ms_ = 0.0;
};

}  // namespace nepho
