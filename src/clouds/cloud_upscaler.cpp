#include "clouds/cloud_upscaler.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "clouds/cloud_resolve.comp.h"
#include "clouds/cloud_select.comp.h"
#include "gpu/commands.h"

namespace nepho {

static_assert(sizeof(shared::UpscaleConstants) == 4 * 16 + 24);

namespace {
/// Pictures that are farther apart are no film, s.
constexpr double kClockJump_s = 1.0;
/// Age of history that still holds, s.
constexpr double kLasting_s = 20.0;
/// A turn of the camera in one frame, as a share of its field of view, that leaves little of the picture in sight.
constexpr float kTurnShare = 0.8f;
/// A leap: farther than this, and than this share of the height.
constexpr double kLeap_m = 500.0, kLeapShare = 0.25;

BufferRef empty_groups(FrameGraph& graph, const char* name) { return graph.create_buffer(name, 16); }
}  // namespace

shared::UpscaleConstants make_upscale_constants(const FrameInfo& now, const FrameInfo& before, uint32_t upscale,
                                                uint32_t number, const glm::dvec3& wind_m) {
  const shared::FrameConstants &a = before.constants, &b = now.constants;
  shared::UpscaleConstants c{};
  c.forward = a.forward;
  c.right = a.right / glm::dot(a.right, a.right);
  c.up = a.up / glm::dot(a.up, a.up);
  c.upscale = upscale;
  c.number = number;
  c.most_samples = static_cast<float>(std::clamp(kLasting_s / (std::abs(now.time_s - before.time_s) * upscale + 1e-9),
                                                 1.0, double{shared::kMostSamples}));
  c.shift_m = glm::vec3(now.camera_ecef_m - before.camera_ecef_m - wind_m);
  c.still = a.forward == b.forward && a.right == b.right && a.up == b.up && c.shift_m == glm::vec3(0.0f);
  if (upscale == 2) {
    c.base = glm::ivec2(static_cast<int>(number & 1u), 0);
    c.step_x = glm::ivec2(1, 1);
    c.step_y = glm::ivec2(1, -1);
  } else {
    const int side = upscale == 16 ? 4 : 2;
    c.base = upscale == 16 ? shared::bayer4_place(number) : shared::halton4_place(number);
    c.step_x = glm::ivec2(side, 0);
    c.step_y = glm::ivec2(0, side);
  }
  return c;
}

bool is_cut(const FrameInfo& now, const FrameInfo& before) {
  const shared::FrameConstants &a = before.constants, &b = now.constants;
  if (!(now.extent == before.extent) || b.frame_index != a.frame_index + 1 || b.frame_index == 0) return true;
  if (std::abs(now.time_s - before.time_s) > kClockJump_s) return true;
  const float wide_a = glm::length(a.right), wide_b = glm::length(b.right);
  if (std::abs(wide_b - wide_a) > 0.2f * wide_a) return true;
  const float turn = std::acos(glm::clamp(glm::dot(a.forward, b.forward), -1.0f, 1.0f));
  if (turn > kTurnShare * 2.0f * std::atan(wide_a)) return true;
  const double way_m = glm::length(now.camera_ecef_m - before.camera_ecef_m);
  return way_m > kLeap_m && way_m > kLeapShare * static_cast<double>(std::abs(b.planet.camera_height_m));
}

CloudUpscaler::CloudUpscaler(gpu::Device& device, const Clouds& clouds)
    : clouds_(clouds),
      select_(device, {.name = "clouds.select", .spirv = cloud_select_comp}),
      select_filling_(device, {.name = "clouds.select", .spirv = cloud_select_comp, .constants = {0, 1}}),
      resolve_(device, {.name = "clouds.resolve", .spirv = cloud_resolve_comp}),
      first_(device, {.name = "clouds.resolve", .spirv = cloud_resolve_comp, .constants = {0, 1}}) {}

/// Mean wind of the layers' bases at the camera, by how much each hides.
glm::dvec3 CloudUpscaler::wind_mps(const FrameInfo& frame) const {
  const shared::CloudConstants& c = clouds_.constants();
  double east = 0.0, north = 0.0, weight = 1e-12;
  for (uint32_t l = 0; l < c.layer_count; ++l) {
    const double w = static_cast<double>(c.layers[l].extinction_per_m * c.layers[l].thickness_m);
    east += w * static_cast<double>(c.layers[l].wind_mps.x);
    north += w * static_cast<double>(c.layers[l].wind_mps.y);
    weight += w;
  }
  const glm::dvec3 up(frame.constants.camera_up);
  const glm::dvec3 to_east = glm::dvec3(-up.y, up.x, 0.0) / std::sqrt(up.x * up.x + up.y * up.y + 0.0025);
  return (to_east * east + glm::cross(up, to_east) * north) / weight;
}

CloudUpscaler::Selection CloudUpscaler::select(FrameGraph& graph, const FrameInfo& frame, uint32_t upscale,
                                               ImageRef depth_m, bool guess_radiance) {
  const bool first = !before_ || upscale != upscale_ || is_cut(frame, *before_);
  number_ = first ? 0 : number_ + 1;
  upscale_ = upscale;
  const FrameInfo& before = first ? frame : *before_;
  const shared::UpscaleConstants constants =
      make_upscale_constants(frame, before, upscale, number_, wind_mps(frame) * (frame.time_s - before.time_s));
  Selection out{.frame = frame, .constants = graph.constants("clouds.upscale", constants)};
  before_ = frame;
  if (first) return out;
  out.frame.constants.jitter_px = shared::upscale_jitter_px(number_, upscale);
  out.frame.buffer = graph.constants("clouds.frame", out.frame.constants);
  const uint64_t pixels = uint64_t{frame.extent.width} * frame.extent.height;
  out.list = {.pixels = graph.create_buffer("clouds.list", 4 * pixels),
              .groups_64 = empty_groups(graph, "clouds.groups_64"),
              .groups_256 = empty_groups(graph, "clouds.groups_256")};
  out.info = graph.create("clouds.info", {.extent = frame.extent, .format = Format::rgba32f});
  out.depths = graph.create("clouds.depths", {.extent = frame.extent, .format = Format::rg32f});
  out.radiance = graph.create("clouds.radiance", {.extent = frame.extent, .format = Format::rgba32f});
  const ImageRef radiance = graph.create_history("clouds.last_radiance", graph.desc(out.radiance));
  const ImageRef place = graph.create_history("clouds.last_place", {.extent = frame.extent, .format = Format::rg32f});
  graph.pass("clouds.select_clear")
      .zero("groups_64", out.list.groups_64)
      .zero("groups_256", out.list.groups_256)
      .record([](gpu::Commands& cmd) { cmd.zero("groups_64").zero("groups_256"); });
  graph.pass("clouds.select")
      .uniform("frame", frame.buffer)
      .uniform("upscale", out.constants)
      .sample("depth_m", depth_m, Sampler::nearest_clamp)
      .sample_history("last_radiance", radiance, Sampler::nearest_clamp)
      .sample_history("last_place", place, Sampler::nearest_clamp)
      .write("pixel_list", out.list.pixels)
      .read_write("groups_64", out.list.groups_64)
      .read_write("groups_256", out.list.groups_256)
      .write("out_info", out.info)
      .write("out_depths", out.depths)
      .write("out_radiance", out.radiance)
      .record([this, guess_radiance, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(guess_radiance ? select_filling_ : select_).dispatch_threads(extent.width, extent.height);
      });
  history_ = {radiance, place};
  return out;
}

CloudUpscaler::Outputs CloudUpscaler::resolve(FrameGraph& graph, const FrameInfo& frame, const Selection& selection,
                                              const Inputs& in) {
  const ImageDesc colour{.extent = frame.extent, .format = Format::rgba32f};
  if (selection.first())
    history_ = {graph.create_history("clouds.last_radiance", colour),
                graph.create_history("clouds.last_place", {.extent = frame.extent, .format = Format::rg32f})};
  const ImageRef info = graph.create("clouds.resolved_info", colour);
  graph.pass("clouds.resolve")
      .uniform("frame", frame.buffer)
      .uniform("upscale", selection.constants)
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .sample("cloud_radiance", in.cloud, Sampler::nearest_clamp)
      .sample("cloud_info", in.info, Sampler::nearest_clamp)
      .sample_history("last_radiance", history_.radiance, Sampler::nearest_clamp)
      .sample_history("last_place", history_.place, Sampler::nearest_clamp)
      .sample_history("last_smooth", history_.radiance)
      .write("out_radiance", history_.radiance)
      .write("out_place", history_.place)
      .write("out_info", info)
      .record([this, first = selection.first(), extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(first ? first_ : resolve_).dispatch_threads(extent.width, extent.height);
      });
  return {history_.radiance, selection.first() ? in.info : info};
}

}  // namespace nepho
