#pragma once
#include <memory>
#include <span>
#include <vector>

#include "atmosphere/atmosphere_tables.h"
#include "clouds/path_tracer.h"
#include "gpu/graph_executor.h"
#include "render/reference_counts.h"
#include "render/reference_shared.h"
#include "scene/scene.h"
#include "terrain/ground_map.h"
#include "terrain/terrain.h"

namespace nepho {

/// The picture of a path-traced reference (docs/reference.md): keeps what a frame shows behind its clouds, traces paths
/// a dispatch at a time and sums them per pixel.
class ReferenceTracer {
 public:
  /// `clouds` must outlive the tracer; they may draw nothing.
  ReferenceTracer(gpu::Device& device, const Scene& scene, const Clouds& clouds, uint32_t spectral_groups);

  /// Pixels' sides are cut into so many sub-pixels, each with its own surface behind the clouds.
  static uint32_t subpixels_of(Extent2D picture);
  /// Throws Error(usage) when a picture is too large to be summed in one buffer.
  static void check_size(Extent2D picture);

  struct Surface {
    Terrain::Outputs terrain;
    ImageRef background;
  };
  /// Copies the images of a frame of sub-pixels; makes the majorants, the key light's table and the ground's map of it.
  /// What the graph was given as `frame` is what begin() must be given.
  void add_surface(FrameGraph& graph, const FrameInfo& frame, const Surface& surface,
                   const AtmosphereTables::Refs& atmosphere);
  /// Zeroes the sums. `frame`: as add_surface() got it; `picture`: the size in pixels.
  void begin(const FrameInfo& frame, Extent2D picture, const Terrain& terrain);

  /// samples[i] more paths for pixel i, those from first_samples[i] on; most_paths() in all and kMostSamples a pixel at
  /// most.
  void trace(gpu::GraphExecutor& executor, const AtmosphereTables& atmosphere, std::span<const uint32_t> samples,
             std::span<const uint32_t> first_samples);
  uint32_t most_paths() const { return tracer_.most_paths(); }
  /// Of a pixel in one trace(): Mesa's software driver ends loops after 65536 turns.
  static constexpr uint32_t kMostSamples = 128;
  /// Forgets all paths.
  void clear();
  std::vector<shared::PixelSums> sums() const;
  /// Background behind the clouds, cd/m2, RGBA: mean over each pixel's sub-pixels.
  std::vector<float> background() const;
  const ReferenceCounts& counts() const { return counts_; }

 private:
  gpu::Device& device_;
  const Clouds& clouds_;
  RenderParams render_;
  float wind_mps_;
  CloudBoundsMap bounds_;
  PathTracer tracer_;
  GroundMap ground_;
  gpu::ComputePipeline copy_, key_pipeline_, shade_;
  gpu::Image depth_, albedo_, normal_, emission_, background_, key_;
  gpu::Buffer sums_;
  FrameInfo frame_;  ///< of sub-pixels
  Extent2D picture_;
  uint32_t subpixels_ = 1;
  bool has_emission_ = false;
  ReferenceCounts counts_;
};

}  // namespace nepho
