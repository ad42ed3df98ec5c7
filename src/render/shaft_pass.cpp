#include "render/shaft_pass.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "gpu/commands.h"
#include "render/haze_march.comp.h"
#include "render/shaft_apply.comp.h"
#include "render/shaft_march.comp.h"

namespace nepho {

static_assert(sizeof(shared::HazeLayerData) == 32);
static_assert(sizeof(shared::ShaftData) == 4 * 32 + 16 + 16);
static_assert(sizeof(shared::ShaftMarchPush) == 12);
static_assert(sizeof(shared::ShaftApplyPush) == 8);

namespace {
constexpr double kFarBelow_m = -1e6;
/// Most of a layer of haze lies below so many scale heights over its base.
constexpr double kBulk = 3.0;

uint32_t blocks_of(uint32_t pixels, uint32_t side) { return (pixels + side - 1) / side; }
}  // namespace

ShaftMethod shaft_method(const ShaftParams& params, const std::string& quality) {
  const std::string name = resolved_shaft_method(params, quality);
  if (name == "shadow-length") return ShaftMethod::shadow_length;
  if (name == "froxel") return ShaftMethod::froxel;
  return name == "screen" ? ShaftMethod::screen : ShaftMethod::none;
}

shared::ShaftData make_shaft_data(const ShaftParams& params, const std::vector<HazeLayer>& haze,
                                  const shared::PlanetView& planet, float air_radius_m, double cloud_top_m,
                                  double ground_m, double ground_albedo) {
  // Scaled heights are as much greater everywhere as they are where the camera is (0.34 % at most).
  const double stretch =
      static_cast<double>(shared::scaled_height_from_geodetic(planet, planet.camera_q_m, 1000.0f)) / 1000.0;
  shared::ShaftData data{};
  double top = kFarBelow_m, bulk = kFarBelow_m;
  for (size_t i = 0; i < haze.size() && i < shared::kMaxHazeLayers; ++i) {
    const HazeLayer& layer = haze[i];
    const double reach = layer.base_m + static_cast<double>(shared::kHazeReach) * layer.scale_height_m;
    const double layer_top = layer.top_m ? std::min(*layer.top_m, reach) : reach;
    top = std::max(top, layer_top);
    bulk = std::max(bulk, std::min(layer_top, layer.base_m + kBulk * layer.scale_height_m));
    data.haze.layers[i] = {.extinction_per_m = static_cast<float>(layer.extinction_per_m),
                           .bottom_m = static_cast<float>(layer.bottom_m.value_or(-12000.0) * stretch),
                           .base_m = static_cast<float>(layer.base_m * stretch),
                           .top_m = static_cast<float>(layer_top * stretch),
                           .scale_height_m = static_cast<float>(layer.scale_height_m * stretch),
                           .albedo = static_cast<float>(layer.albedo),
                           .g = static_cast<float>(layer.phase_g),
                           .pad0 = 0.0f};
  }
  data.haze.top_m = static_cast<float>(top * stretch);
  data.haze.bulk_m = static_cast<float>(bulk * stretch);
  data.haze.radius_m = air_radius_m;
  // Scaled heights of a geodetic one differ over the globe: none is above this.
  data.cloud_top_m = static_cast<float>(cloud_top_m * 1.0034 + 1.0);
  data.intensity = static_cast<float>(params.intensity);
  data.ground_m = static_cast<float>(ground_m * stretch);
  data.ground_albedo = static_cast<float>(ground_albedo);
  return data;
}

const gpu::ComputePipeline& ShaftPass::pipeline(Kind kind, uint32_t haze_layers, uint32_t steps) {
  gpu::ComputePipeline& wanted = pipelines_[{kind, haze_layers, steps}];
  if (!wanted) {
    const std::span<const uint32_t> spirv[] = {shaft_march_comp, haze_march_comp, shaft_apply_comp};
    const char* const names[] = {"shafts.march", "haze.march", "shafts.apply"};
    wanted = gpu::ComputePipeline(device_, {.name = names[kind],
                                            .spirv = spirv[kind],
                                            .constants = {spectral_groups_, 0, 0, 0, 0, 0, haze_layers, steps}});
  }
  return wanted;
}

ShaftPass::Outputs ShaftPass::add(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                                  const HazeParams& haze, ShaftMethod method, const Inputs& in) {
  const std::vector<HazeLayer> layers = drawn_haze(haze);
  const bool shade = in.shadow.map && method != ShaftMethod::none && params.intensity > 0.0;
  if (!shade && layers.empty()) return {in.background, in.cloud};
  const uint32_t side = params.downscale, haze_layers = static_cast<uint32_t>(layers.size());
  const Extent2D blocks{blocks_of(frame.extent.width, side), blocks_of(frame.extent.height, side)};
  const BufferRef data =
      graph.constants("shafts", make_shaft_data(params, layers, frame.constants.planet, in.air->radius_m,
                                                shade ? in.cloud_top_m : kFarBelow_m, in.ground_m, in.ground_albedo));
  const auto image = [&](const char* name) {
    return graph.create(name, {.extent = blocks, .format = Format::rgba32f});
  };
  const ImageRef near = image("shafts.near"), far = image("shafts.far"), cloud = image("shafts.cloud"),
                 depths = image("shafts.depths");
  const uint32_t has_clouds = in.cloud ? 1 : 0;
  const ImageRef info = in.cloud ? in.cloud_info : in.depth_m;
  auto march = graph.pass(shade ? "shafts.march" : "haze.march");
  march.uniform("frame", frame.buffer)
      .uniform("shafts", data)
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .sample("cloud_info", info, Sampler::nearest_clamp)
      .write("out_near", near)
      .write("out_far", far)
      .write("out_cloud", cloud)
      .write("out_depths", depths);
  AtmosphereTables::bind(march, in.atmosphere);
  if (shade) bind_cloud_shadow(march, in.shadow);
  const gpu::ComputePipeline& marcher = pipeline(shade ? shadow_march : haze_march, haze_layers, params.steps);
  const shared::ShaftMarchPush march_push{side, has_clouds, 0};
  march.record([&marcher, blocks, march_push](gpu::Commands& cmd) {
    cmd.bind(marcher).push(march_push).dispatch_threads(blocks.width, blocks.height);
  });

  Outputs out{.background = graph.create("background.air", {.extent = frame.extent, .format = Format::rgba32f}),
              .cloud = {}};
  const Extent2D cloud_extent = in.cloud ? frame.extent : Extent2D{1, 1};
  const ImageRef out_cloud = graph.create("clouds.air", {.extent = cloud_extent, .format = Format::rgba32f});
  if (in.cloud) out.cloud = out_cloud;
  const shared::ShaftApplyPush apply_push{side, has_clouds};
  const gpu::ComputePipeline& applier = pipeline(apply, 0, 0);
  graph.pass("shafts.apply")
      .uniform("frame", frame.buffer)
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .sample("cloud_info", info, Sampler::nearest_clamp)
      .sample("near_tex", near, Sampler::nearest_clamp)
      .sample("far_tex", far, Sampler::nearest_clamp)
      .sample("cloud_tex", cloud, Sampler::nearest_clamp)
      .sample("depths_tex", depths, Sampler::nearest_clamp)
      .sample("background", in.background, Sampler::nearest_clamp)
      .sample("cloud_radiance", in.cloud ? in.cloud : in.background, Sampler::nearest_clamp)
      .write("out_background", out.background)
      .write("out_cloud", out_cloud)
      .record([&applier, apply_push, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(applier).push(apply_push).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
