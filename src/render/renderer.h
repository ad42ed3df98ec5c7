#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "astro/utc_time.h"
#include "gpu/graph_executor.h"
#include "io/image_buffer.h"
#include "render/camera_pose.h"
#include "render/night_sky.h"
#include "render/reference_counts.h"
#include "scene/scene.h"
#include "terrain/terrain.h"
#include "weather/weather_map.h"

namespace nepho {

struct FrameOutputs;
struct FrameReadback;

/// Wall-clock and GPU times of a render, ms.
struct RenderTimings {
  double startup_ms = 0.0;     ///< making the renderer: pipelines, tables, noise, weather
  double atmosphere_ms = 0.0;  ///< of startup: atmosphere tables
  bool atmosphere_cached = false;
  double clouds_ms = 0.0;               ///< of startup: noise and weather
  double terrain_ms = 0.0;              ///< selecting, loading and uploading tiles for this view
  double frame_ms = 0.0;                ///< recording, GPU work and wait of one frame (mean over frames)
  double readback_ms = 0.0;             ///< downloads and output layers
  std::vector<gpu::PassTiming> passes;  ///< of the last frame
  uint64_t gpu_memory_bytes = 0;
  double steps_per_px = 0.0, samples_per_px = 0.0;  ///< of the clouds' march, with RenderRequest::count_work
  /// Cells of light inside clouds, with RenderRequest::count_work: seen; of them traced in full, and with one path more.
  uint32_t light_cells = 0, light_fresh = 0, light_refresh = 0;
  ReferenceCounts reference;  ///< of quality reference
};

/// How far a path-traced reference is.
struct ReferenceProgress {
  double paths = 0.0;     ///< of a pixel so far, mean
  double noise = 0.0;     ///< relative standard error of the luminance that 95 % of the pixels have; 1 while unknown
  double fraction = 0.0;  ///< 0..1, about
  double elapsed_s = 0.0, left_s = 0.0;
};

struct RenderRequest {
  bool display = true;           ///< make the 8-bit picture
  bool layers = true;            ///< make the float layers
  std::set<std::string> wanted = {};  ///< layer names; empty: all
  std::string debug = {};        ///< a name of known_debug_views() instead of the picture; empty: the picture
  /// Scene time since the last picture, s, for the adaptation of automatic exposure; 0: a still, which does not adapt.
  double frame_interval_s = 0.0;
  /// Its place in a sequence drawn by one renderer, 0 first: seeds noise.
  uint32_t frame_number = 0;
  /// One of a stream of pictures that are wanted as fast as can be: light inside clouds comes from fewer, larger cells
  /// from the first picture on, and grows finer while pictures follow each other (docs/light.md).
  bool live = false;
  bool read_back = true;    ///< false: the 8-bit picture is made but not brought to the CPU; for benchmarks
  bool count_work = false;  ///< fill RenderTimings::steps_per_px, samples_per_px, light_*
  /// Quality reference: called between dispatches; false ends the picture where it is.
  std::function<bool(const ReferenceProgress&)> on_progress = {};
  /// Quality reference: goes on from this picture's paths (its layers R, G, B, variance, samples and cloud). Null: from
  /// none. Throws Error(input) for a picture without them or of another size.
  const ImageBuffer* resume = nullptr;
  /// Draw the ground as far as it is loaded, instead of waiting for all that the view needs.
  bool incomplete_ok = false;
  double ground_wait_s = 0.0;  ///< with incomplete_ok: how long to wait for ground all the same, s
  /// Told how many of the tiles of ground that the view lacks are there.
  std::function<void(size_t done, size_t of)> on_ground = {};
};

struct RenderResult {
  ImageBuffer layers;                ///< scene-linear, cd/m2, with the asked layers
  std::vector<uint8_t> display_rgb;  ///< sRGB, 8 bit, width * height * 3
  CameraPose pose;
  double ev100 = 0.0;           ///< exposure of the 8-bit picture
  ReferenceProgress reference;  ///< of quality reference
  bool interrupted = false;     ///< on_progress said so
};

/// Draws scenes: orders one frame as docs/architecture.md tells it. Holds tables, noise and tiles between frames.
class Renderer {
 public:
  /// Throws Error for parameters out of range or when GPU memory is short.
  Renderer(gpu::Device& device, TerrainSources sources, const Scene& scene, const SkySources& sky = {},
           const WeatherSources& weather = {});
  ~Renderer();
  /// The camera of the scene, placed on the drawn ground where its height depends on it.
  CameraPose pose() const;
  /// Moves the camera; from the next render() on. Throws Error(usage) as resolve_camera() does.
  void set_camera(const CameraParams& camera);
  /// Makes in the background the ground that a later picture from `camera` will need; for sequences drawn with
  /// RenderRequest::incomplete_ok. Call after render().
  void prefetch(const CameraParams& camera);
  /// Moves the scene's clock: sun, moon, stars and clouds are those of the moment from the next render() on. With a
  /// second moment sun, moon and stars are that one's.
  void set_time(const UtcInstant& utc, const std::optional<UtcInstant>& sky = std::nullopt);
  RenderResult render(const RenderRequest& request);
  const RenderTimings& timings() const { return timings_; }
  const Terrain& terrain() const;

  /// Changes the air: its tables are computed a little in every following render(), which draws the old air until they
  /// are ready. Throws Error(usage) for parameters that make no sense.
  void set_atmosphere(const AtmosphereParams& params);
  double atmosphere_progress() const;  ///< 0..1; 1: nothing to do

 private:
  void advance_atmosphere();
  RenderResult render_reference(const RenderRequest& request);
  void read_layers(FrameReadback& readback, const FrameOutputs& out);
  void read_display(RenderResult& result, const FrameOutputs& out);
  void show_mean(RenderResult& result, const FrameReadback& readback, double interval_s);
  void count_work(const FrameOutputs& out, size_t pixels, bool live);
  struct Parts;
  static std::vector<uint8_t> debug_picture(Parts& parts, const std::string& view, ImageRef image, size_t pixels);
  Scene scene_;
  gpu::Device& device_;
  RenderTimings timings_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace nepho
