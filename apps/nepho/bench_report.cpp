// What `nepho bench` prints and writes.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "nepho/bench.h"

namespace nepho {

namespace {

constexpr double kMiB = 1024.0 * 1024.0;
constexpr double kShown_ms = 0.01;  ///< dearer passes have a line of their own

constexpr size_t kFirstShown = 6;  ///< dearest passes of the first frame

double mib(uint64_t bytes) { return static_cast<double>(bytes) / kMiB; }

}  // namespace

void print_bench(std::ostream& out, const BenchResult& r) {
  out << fmt::format("{} {}x{} {} upscale {}, {} frames on {}\n", r.scene, r.size.width, r.size.height, r.quality,
                     r.upscale, r.frames, r.device);
  out << fmt::format("  frame      median {:9.2f} ms   min {:9.2f}   max {:9.2f}   gpu {:9.2f} ms\n", r.frame_median_ms,
                     r.frame_min_ms, r.frame_max_ms, r.gpu_median_ms);
  out << fmt::format("  first frame {:.0f} ms, start-up {:.0f} ms; march: {:.1f} steps, {:.1f} samples a pixel\n",
                     r.first_frame_ms, r.startup_ms, r.steps_per_px, r.samples_per_px);
  out << fmt::format(
      "  memory: images {:.0f} MiB, buffers {:.0f}, host visible {:.0f}, process {:.0f}; grew by {:.1f} (GPU) and "
      "{:.1f} "
      "MiB\n",
      mib(r.gpu_images_bytes), mib(r.gpu_buffers_bytes), mib(r.gpu_host_visible_bytes), mib(r.host_resident_bytes),
      mib(r.gpu_growth_bytes), mib(r.host_resident_growth_bytes));
  out << "  first frame:";
  for (size_t i = 0; i < std::min<size_t>(r.first_passes.size(), kFirstShown); ++i)
    out << fmt::format("{} {} {:.0f} ms", i > 0 ? "," : "", r.first_passes[i].name, r.first_passes[i].median_ms);
  out << "\n";
  double rest = 0.0;
  for (const BenchPass& p : r.passes)
    if (p.max_ms >= kShown_ms)
      out << fmt::format("  {:<28} {:9.3f} ms   min {:9.3f}   max {:9.3f}\n", p.name, p.median_ms, p.min_ms, p.max_ms);
    else
      rest += p.median_ms;
  if (rest > 0.0) out << fmt::format("  {:<28} {:9.3f} ms\n", "other passes", rest);
  out.flush();
}

std::string bench_json(const std::vector<BenchResult>& results) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const BenchResult& r : results) {
    nlohmann::ordered_json j;
    j["device"] = r.device;
    j["driver"] = r.driver;
    j["scene"] = r.scene;
    j["size"] = fmt::format("{}x{}", r.size.width, r.size.height);
    j["quality"] = r.quality;
    j["upscale"] = r.upscale;
    j["frames"] = r.frames;
    j["frame_median_ms"] = r.frame_median_ms;
    j["frame_min_ms"] = r.frame_min_ms;
    j["frame_max_ms"] = r.frame_max_ms;
    j["gpu_median_ms"] = r.gpu_median_ms;
    j["passes"] = nlohmann::ordered_json::array();
    for (const BenchPass& p : r.passes)
      j["passes"].push_back({{"name", p.name}, {"min_ms", p.min_ms}, {"median_ms", p.median_ms}, {"max_ms", p.max_ms}});
    j["first_frame_passes"] = nlohmann::ordered_json::array();
    for (const BenchPass& p : r.first_passes) j["first_frame_passes"].push_back({{"name", p.name}, {"ms", p.median_ms}});
    j["steps_per_px"] = r.steps_per_px;
    j["samples_per_px"] = r.samples_per_px;
    j["first_frame_ms"] = r.first_frame_ms;
    j["startup_ms"] = r.startup_ms;
    j["memory_bytes"] = {{"gpu_images", r.gpu_images_bytes},
                         {"gpu_buffers", r.gpu_buffers_bytes},
                         {"gpu_host_visible", r.gpu_host_visible_bytes},
                         {"host_resident", r.host_resident_bytes},
                         {"gpu_growth", r.gpu_growth_bytes},
                         {"host_growth", r.host_resident_growth_bytes}};
    all.push_back(std::move(j));
  }
  return all.dump(2) + "\n";
}

}  // namespace nepho
