#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gpu/frame_graph.h"
#include "gpu/frame_graph_compile.h"

namespace nepho::gpu {

struct PassTiming {
  std::string name;
  double gpu_ms = 0.0;
};

/// Runs frame graphs on a device: owns the transient images (reused from frame to frame) and the history images.
class GraphExecutor {
 public:
  explicit GraphExecutor(Device& device);
  ~GraphExecutor();
  GraphExecutor(const GraphExecutor&) = delete;
  GraphExecutor& operator=(const GraphExecutor&) = delete;

  /// Compiles, records, submits and waits.
  void run(const FrameGraph& graph);
  /// Several frames in one command buffer, in order; kept resources are those of the last frame.
  void run(const std::vector<const FrameGraph*>& frames);

  /// Texels of a kept image of the last run, mip 0, tightly packed.
  std::vector<std::byte> download(ImageRef image);
  std::vector<std::byte> download(BufferRef buffer);
  /// As download, as an array of T (float, u16...).
  template <typename T, typename Ref>
  std::vector<T> read(Ref ref) {
    const std::vector<std::byte> bytes = download(ref);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
  }
  /// Of the last run, by GPU timestamps. Software devices put theirs in when a whole batch is flushed, not when a pass
  /// ends: there every pass is submitted by itself and timed by the clock around it (with validation too, which wants
  /// to see whole frames, the batch's own timestamps have to do).
  const std::vector<PassTiming>& timings() const { return timings_; }
  Device& device() { return device_; }

 private:
  struct Frame;
  struct History {
    Image images[2];
    uint32_t current = 0;
    bool fresh = true;
  };
  void prepare(Frame& frame);
  void begin_history(Frame& frame, VkCommandBuffer cmd);
  void record_pass(Frame& frame, const CompiledPass& compiled, VkCommandBuffer cmd);
  void run_in_one_submission(const std::vector<std::unique_ptr<Frame>>& frames);
  void run_pass_by_pass(const std::vector<std::unique_ptr<Frame>>& frames);
  Device& device_;
  std::vector<Image> image_pool_;
  std::vector<Buffer> buffer_pool_;
  std::map<std::string, History> history_;
  std::vector<PassTiming> timings_;
  std::unique_ptr<Frame> last_;
};

}  // namespace nepho::gpu
