#pragma once
#include <array>
#include <functional>
#include <span>

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
  /// Traces samples[i] paths for pixel (or ray) i, those from first_samples[i] on, in as many dispatches as the device
  /// wants; most_paths() in all at most. Images that the mode does not read may be absent; `make_inputs` is asked for
  /// every graph anew. `push`: items and pixels are filled in.
  void run(gpu::GraphExecutor& executor, const FrameInfo& frame,
           const std::function<Inputs(FrameGraph&, const FrameInfo&)>& make_inputs, std::span<const uint32_t> samples,
           std::span<const uint32_t> first_samples, shared::PathPush push);
  /// shared::PathResult of the last run(), pixel after pixel, and its shared::PathPlan.
  const gpu::Buffer& results() const { return results_; }
  const gpu::Buffer& plan() const { return plan_; }
  /// Of the last run().
  const shared::PathCounts& counts() const { return counts_; }
  double trace_ms() const { return trace_ms_; }  ///< by GPU timestamps

  /// Of one run(): what the results' buffer holds.
  uint32_t most_paths() const;

 private:
  const gpu::ComputePipeline& pipeline(uint32_t phases);
  gpu::Device& device_;
  const Clouds& clouds_;
  Mode mode_;
  gpu::Image none_2d_, none_array_;
  gpu::Buffer results_, work_, lanes_, plan_;
  std::array<gpu::ComputePipeline, 2> trace_;  ///< by phases - 1
  shared::PathCounts counts_{};
  double trace_ms_ = 0.0;
};

}  // namespace nepho
