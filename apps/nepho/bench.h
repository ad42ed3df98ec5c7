#pragma once
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "gpu/types.h"
#include "scene/scene.h"

namespace nepho {

struct RasterAccess;

/// One line of a benchmark: a scene at one size, quality and upscaling.
struct BenchCase {
  std::string name;  ///< of the scene
  Scene scene;
  double speed_mps = 0.0;   ///< the camera flies ahead that fast
  double turn_deg_s = 0.0;  ///< and turns to the right that fast
};

struct BenchRequest {
  std::vector<BenchCase> cases;
  uint32_t frames = 16;   ///< measured, after the warm-up
  uint32_t warm_up = 16;  ///< frames before, the first one apart: caches fill and pipelines are made
  double fps = 60.0;      ///< the scene's clock goes on by 1 / fps a frame
  std::string device;     ///< as gpu::DeviceOptions::device
  bool validation = false;
  std::filesystem::path pictures;  ///< folder for the first and the last picture of each case; empty: none are kept
};

struct BenchPass {
  std::string name;
  double min_ms = 0.0, median_ms = 0.0, max_ms = 0.0;  ///< GPU time a frame of all passes of that name
};

/// What was measured. Times are wall-clock but for those called gpu.
struct BenchResult {
  std::string device, driver, scene, quality;
  Extent2D size;
  uint32_t upscale = 1, frames = 0;
  double frame_median_ms = 0.0, frame_min_ms = 0.0, frame_max_ms = 0.0;  ///< a frame, with its 8-bit picture
  double gpu_median_ms = 0.0;                                            ///< sum of the passes
  std::vector<BenchPass> passes;                                         ///< dearest first
  std::vector<BenchPass> first_passes;                                   ///< of the first frame, dearest first
  double steps_per_px = 0.0, samples_per_px = 0.0;                       ///< of the clouds' march, last frame
  double first_frame_ms = 0.0;  ///< with the ground that it needs, pipelines and caches
  double startup_ms = 0.0;      ///< files, device and what outlives frames
  uint64_t gpu_images_bytes = 0, gpu_buffers_bytes = 0, gpu_host_visible_bytes = 0;
  uint64_t host_resident_bytes = 0;         ///< of the process, at the end
  uint64_t host_resident_growth_bytes = 0;  ///< of it since the first measured frame
  uint64_t gpu_growth_bytes = 0;            ///< of GPU memory since then
};

/// Measures one case after the other; each is told to `on_result` when it is done. Throws Error.
std::vector<BenchResult> run_bench(const BenchRequest& request, const RasterAccess& rasters, std::ostream& out);

/// A case as lines of text.
void print_bench(std::ostream& out, const BenchResult& result);
/// All cases as a JSON array of objects whose members end in _ms and _bytes.
std::string bench_json(const std::vector<BenchResult>& results);

}  // namespace nepho
