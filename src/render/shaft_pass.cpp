#include "render/shaft_pass.h"

#include <algorithm>
#include <cmath>

#include "common/region_map.h"
#include "gpu/commands.h"
#include "render/froxel_apply.comp.h"
#include "render/froxel_fill_haze.comp.h"
#include "render/froxel_fill_shaft.comp.h"
#include "render/haze_march.comp.h"
#include "render/screen_march.comp.h"
#include "render/shaft_apply.comp.h"
#include "render/shaft_march.comp.h"

namespace nepho {

static_assert(sizeof(shared::HazeLayerData) == 32);
static_assert(sizeof(shared::ShaftData) == 4 * 32 + 16 + 16);
static_assert(sizeof(shared::ShaftMarchPush) == 16);
static_assert(sizeof(shared::ShaftApplyPush) == 16);
static_assert(sizeof(shared::FroxelGrid) == 24);
static_assert(sizeof(shared::FroxelApplyPush) == 28);

namespace {
constexpr double kFarBelow_m = -1e6;
/// Most of a layer of haze lies below so many scale heights over its base.
constexpr double kBulk = 3.0;
/// Growth of the frustum grid's slices at most: from 80 m on, over 150 km.
constexpr double kGrowth = 5.0;
/// Of the march through the air of screen-space shafts, whose shade is the same along a ray.
constexpr uint32_t kScreenMarchSteps = 8;
/// Angle that the side of a block of pixels covers at most: 0.5 degrees, in a sequence its width 0.75.
constexpr double kWidestBlock_rad = 0.0087, kWidestInSequence_rad = 0.013;
/// Width of blocks in a sequence at least, where these are not too wide.
constexpr double kSequenceBlock_px = 4.0;
/// Side of blocks in large pictures: a quarter of a degree, and so many rows of them, at most.
constexpr double kBlock_rad = 0.0044, kBlockRows = 270.0, kMostBlock_px = 8.0;
/// Optical depth of what glows around the sun over clouds, at screen_glow 1.
constexpr double kGlowDepth = 0.02;

uint32_t blocks_of(uint32_t pixels, uint32_t side) { return (pixels + side - 1) / side; }

/// With haze every pixel has a ray of its own: what lies low over distant ground changes from row to row. So it has
/// where blocks would be wider than shafts: in small pictures, which cost little. Shafts are as wide in large pictures
/// as in small ones, and blocks grow with their pixels. In a sequence they are wider than high: towards the horizon
/// distances change from row to row.
glm::uvec2 block_of(const FrameInfo& frame, const ShaftParams& params, const std::vector<HazeLayer>& haze,
                    bool sequence) {
  if (!haze.empty()) return {1, 1};
  const double pixel_rad = static_cast<double>(frame.constants.pixel_angle_rad);
  const double wanted = std::max(static_cast<double>(params.downscale),
                                 std::min({kBlock_rad / pixel_rad, frame.extent.height / kBlockRows, kMostBlock_px}));
  const auto high = static_cast<uint32_t>(std::clamp(kWidestBlock_rad / pixel_rad, 1.0, wanted));
  if (!sequence) return {high, high};
  const auto wide = static_cast<uint32_t>(std::clamp(kWidestInSequence_rad / pixel_rad, 1.0, kSequenceBlock_px));
  return {std::max(wide, high), std::max(std::min(wide, 3u), high)};
}

/// Whose shade is drawn, and geodetic height that it does not reach.
struct Shade {
  bool clouds = false, terrain = false;
  double top_m = kFarBelow_m;
  explicit operator bool() const { return clouds || terrain; }
};

Shade shade_of(const ShaftParams& params, ShaftMethod method, const ShaftPass::Air& air) {
  Shade shade;
  if (method == ShaftMethod::none || params.intensity <= 0.0) return shade;
  shade.clouds = static_cast<bool>(air.shadow.map);
  shade.terrain = static_cast<bool>(air.terrain);
  if (shade.clouds) shade.top_m = air.cloud_top_m;
  if (shade.terrain) shade.top_m = std::max(shade.top_m, air.terrain_top_m);
  return shade;
}

double haze_top_m(const HazeLayer& layer) {
  const double reach = layer.base_m + static_cast<double>(shared::kHazeReach) * layer.scale_height_m;
  return layer.top_m ? std::min(*layer.top_m, reach) : reach;
}

/// Geodetic height above which air is as it was.
double changed_top_m(const Shade& shade, const std::vector<HazeLayer>& haze) {
  double top_m = shade.top_m;
  for (const HazeLayer& layer : haze) top_m = std::max(top_m, haze_top_m(layer));
  return top_m;
}

/// Scaled heights of a geodetic one differ over the globe: none is above this.
float scaled_top(double geodetic_m) { return static_cast<float>(geodetic_m * 1.0034 + 1.0); }
}  // namespace

ShaftPass::ShaftPass(gpu::Device& device, uint32_t spectral_groups)
    : device_(device),
      spectral_groups_(spectral_groups),
      no_terrain_(device.create_image(
          {.name = "shafts.no_terrain", .extent = {1, 1}, .format = Format::rgba32f, .layers = 2})) {
  const std::vector<std::byte> zeros(16);
  const gpu::ImageUpload uploads[] = {{.image = &no_terrain_, .bytes = zeros, .layer = 0},
                                      {.image = &no_terrain_, .bytes = zeros, .layer = 1}};
  device.upload(uploads);
}

void ShaftPass::bind_terrain(FrameGraph& graph, FrameGraph::PassBuilder& pass, const TerrainVolumeRefs& terrain) const {
  bind_terrain_volume(pass, terrain ? terrain
                                    : TerrainVolumeRefs{graph.import(no_terrain_),
                                                        graph.constants("shafts.no_terrain", shared::RegionMap{})});
}

ShaftMethod shaft_method(const ShaftParams& params, const std::string& quality) {
  const std::string name = resolved_shaft_method(params, quality);
  if (name == "shadow-length") return ShaftMethod::shadow_length;
  if (name == "froxel") return ShaftMethod::froxel;
  return name == "screen" ? ShaftMethod::screen : ShaftMethod::none;
}

shared::HazeData make_haze_data(const std::vector<HazeLayer>& haze, const shared::PlanetView& planet,
                                float air_radius_m) {
  // Scaled heights are as much greater everywhere as they are where the camera is (0.34 % at most).
  const double stretch =
      static_cast<double>(shared::scaled_height_from_geodetic(planet, planet.camera_q_m, 1000.0f)) / 1000.0;
  const auto scaled = [&](double height_m) { return static_cast<float>(height_m * stretch); };
  shared::HazeData data{};
  double top = kFarBelow_m, bulk = kFarBelow_m;
  for (size_t i = 0; i < haze.size() && i < shared::kMaxHazeLayers; ++i) {
    const HazeLayer& layer = haze[i];
    const double layer_top = haze_top_m(layer);
    top = std::max(top, layer_top);
    bulk = std::max(bulk, std::min(layer_top, layer.base_m + kBulk * layer.scale_height_m));
    data.layers[i] = {.extinction_per_m = static_cast<float>(layer.extinction_per_m),
                      .bottom_m = scaled(layer.bottom_m.value_or(-12000.0)),
                      .base_m = scaled(layer.base_m),
                      .top_m = scaled(layer_top),
                      .scale_height_m = scaled(layer.scale_height_m),
                      .albedo = static_cast<float>(layer.albedo),
                      .g = static_cast<float>(layer.phase_g),
                      .pad0 = 0.0f};
  }
  data.top_m = scaled(top);
  data.bulk_m = scaled(bulk);
  data.radius_m = air_radius_m;
  return data;
}

void bind_froxels(FrameGraph::PassBuilder& pass, const FroxelRefs& refs) {
  pass.uniform("froxels", refs.grid)
      .sample("froxel_light", refs.light)
      .sample("froxel_transmittance", refs.transmittance);
}

const gpu::ComputePipeline& ShaftPass::pipeline(Kind kind, uint32_t haze_layers, uint32_t steps, uint32_t more,
                                                bool terrain, bool quick) {
  const uint32_t shaded = terrain ? 1 : 0, few = quick ? 1 : 0;
  gpu::ComputePipeline& wanted = pipelines_[{kind, haze_layers, steps, more, shaded, few}];
  if (!wanted) {
    const std::span<const uint32_t> spirv[] = {shaft_march_comp, screen_march_comp,      haze_march_comp,
                                               shaft_apply_comp, froxel_fill_shaft_comp, froxel_fill_haze_comp,
                                               froxel_apply_comp};
    const char* const names[] = {"shafts.march", "shafts.screen", "haze.march",   "shafts.apply",
                                 "froxels.fill", "froxels.fill",  "froxels.apply"};
    wanted = gpu::ComputePipeline(
        device_, {.name = names[kind],
                  .spirv = spirv[kind],
                  .constants = {spectral_groups_, 0, 0, 0, 0, 0, haze_layers, steps, more, shaded, few}});
  }
  return wanted;
}

BufferRef ShaftPass::constants(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                               const std::vector<HazeLayer>& haze, double shade_top_m, const Air& air) const {
  const shared::PlanetView& planet = frame.constants.planet;
  const float top_m = shade_top_m > kFarBelow_m ? scaled_top(shade_top_m) : static_cast<float>(kFarBelow_m);
  return graph.constants("shafts", shared::ShaftData{.haze = make_haze_data(haze, planet, air.uniform->radius_m),
                                                     .shade_top_m = top_m,
                                                     .intensity = static_cast<float>(params.intensity),
                                                     .ground_m = shared::scaled_height_from_geodetic(
                                                         planet, planet.camera_q_m, static_cast<float>(air.ground_m)),
                                                     .ground_albedo = static_cast<float>(air.ground_albedo)});
}

FroxelRefs ShaftPass::add_froxels(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                                  const HazeParams& haze, ShaftMethod method, const Air& air, bool light) {
  const std::vector<HazeLayer> layers = drawn_haze(haze);
  const Shade shade = shade_of(params, method, air);
  const double top_m = std::max(changed_top_m(shade, layers), 0.0);
  // From above, the grid begins where something may be and reaches over the horizon.
  const double height_m = static_cast<double>(frame.constants.planet.camera_height_m);
  const double start_m = std::max(height_m - 1.01 * top_m - 10.0, 0.0);
  const double radius_m = static_cast<double>(air.uniform->radius_m);
  const double horizon_m = std::sqrt(std::max(height_m, 0.0) * (2.0 * radius_m + std::max(height_m, 0.0)));
  const double end_m = start_m > 0.0 ? std::max(start_m + params.froxel_range_m, horizon_m + params.froxel_range_m)
                                     : params.froxel_range_m;
  FroxelRefs out;
  out.data = {.size = {params.froxels_wide, params.froxels_high, params.froxel_slices},
              .start_m = static_cast<float>(start_m),
              .end_m = static_cast<float>(end_m),
              .growth = static_cast<float>(std::min(kGrowth, std::log(end_m / std::max(start_m, 1.0))))};
  out.grid = graph.constants("froxels", out.data);
  const auto volume = [&](const char* name, bool wanted) {
    const Extent3D extent{wanted ? out.data.size.x : 1, wanted ? out.data.size.y : 1, wanted ? out.data.size.z : 2};
    return graph.create(name, {.extent = extent, .format = Format::rgba32f});
  };
  out.change = volume("froxels.change", true);
  out.light = volume("froxels.light", light);
  out.transmittance = volume("froxels.transmittance", light);
  auto fill = graph.pass("froxels.fill");
  fill.uniform("frame", frame.buffer)
      .uniform("shafts", constants(graph, frame, params, layers, shade.top_m, air))
      .write("out_change", out.change)
      .write("out_light", out.light)
      .write("out_transmittance", out.transmittance);
  AtmosphereTables::bind(fill, air.atmosphere);
  if (shade.clouds) bind_cloud_shadow(fill, air.shadow);
  bind_terrain(graph, fill, air.terrain);
  const gpu::ComputePipeline& filler = pipeline(shade.clouds ? shadow_fill : haze_fill,
                                                static_cast<uint32_t>(layers.size()), 0, light ? 1 : 0, shade.terrain);
  fill.record([&filler, grid = out.data](gpu::Commands& cmd) {
    cmd.bind(filler).push(grid).dispatch_threads(grid.size.x, grid.size.y);
  });
  return out;
}

ShaftPass::Blocks ShaftPass::add_march(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                                       const std::vector<HazeLayer>& haze, ShaftMethod method, const Air& air,
                                       const Inputs& in) {
  const Shade shade = shade_of(params, method, air);
  const bool screen = shade.clouds && method == ShaftMethod::screen;
  const glm::uvec2 block = block_of(frame, params, haze, air.sequence);
  const Extent2D blocks{blocks_of(frame.extent.width, block.x), blocks_of(frame.extent.height, block.y)};
  const auto image = [&](const char* name) {
    return graph.create(name, {.extent = blocks, .format = Format::rgba32f});
  };
  const Blocks out{image("shafts.near"), image("shafts.far"), image("shafts.cloud_near"), image("shafts.cloud_far"),
                   image("shafts.depths")};
  const Kind kind = screen ? screen_march : shade.clouds ? shadow_march : haze_march;
  const gpu::ComputePipeline& marcher =
      pipeline(kind, static_cast<uint32_t>(haze.size()),
               screen && haze.empty() && !shade.terrain ? kScreenMarchSteps : params.steps, screen ? params.steps : 0,
               shade.terrain, air.sequence);
  auto march = graph.pass(screen ? "shafts.screen" : shade ? "shafts.march" : "haze.march");
  march.uniform("frame", frame.buffer)
      .uniform("shafts", constants(graph, frame, params, haze, shade.top_m, air))
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .sample("cloud_depths", in.cloud ? in.cloud_depths : in.depth_m, Sampler::nearest_clamp)
      .write("out_near", out.near)
      .write("out_far", out.far)
      .write("out_cloud_near", out.cloud_near)
      .write("out_cloud_far", out.cloud_far)
      .write("out_depths", out.depths);
  AtmosphereTables::bind(march, air.atmosphere);
  if (screen)
    march.sample("cloud_radiance", in.cloud, Sampler::nearest_clamp);
  else if (shade.clouds)
    bind_cloud_shadow(march, air.shadow);
  bind_terrain(graph, march, air.terrain);
  const shared::ShaftMarchPush push{block, in.cloud ? 1u : 0u,
                                    screen ? static_cast<float>(kGlowDepth * params.screen_glow) : 0.0f};
  march.record([&marcher, blocks, push](gpu::Commands& cmd) {
    cmd.bind(marcher).push(push).dispatch_threads(blocks.width, blocks.height);
  });
  return out;
}

ShaftPass::Outputs ShaftPass::add(FrameGraph& graph, const FrameInfo& frame, const ShaftParams& params,
                                  const HazeParams& haze, ShaftMethod method, const Air& air, const Inputs& in) {
  const std::vector<HazeLayer> layers = drawn_haze(haze);
  if (!shade_of(params, method, air) && layers.empty()) return {in.background, in.cloud};
  const bool froxel = method == ShaftMethod::froxel && in.froxels.change;
  const Blocks blocks = froxel ? Blocks{} : add_march(graph, frame, params, layers, method, air, in);
  const ImageRef background = graph.create("background.air", {.extent = frame.extent, .format = Format::rgba32f});
  const Extent2D cloud_extent = in.cloud ? frame.extent : Extent2D{1, 1};
  const ImageRef cloud = graph.create("clouds.air", {.extent = cloud_extent, .format = Format::rgba32f});
  const uint32_t has_clouds = in.cloud ? 1 : 0;
  const auto add_part = [&](Part part) {
    const bool listed = part == cloud_part;
    auto pass = graph.pass(listed ? "shafts.apply_clouds" : froxel ? "froxels.apply" : "shafts.apply");
    pass.uniform("frame", frame.buffer)
        .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
        .sample("cloud_depths", in.cloud ? in.cloud_depths : in.depth_m, Sampler::nearest_clamp)
        .sample("background", in.background, Sampler::nearest_clamp)
        .sample("cloud_radiance", in.cloud ? in.cloud : in.background, Sampler::nearest_clamp)
        .sample("cloud_near", in.cloud ? in.cloud_near : in.background, Sampler::nearest_clamp)
        .write("out_background", background)
        .write("out_cloud", cloud);
    bind_pixel_list(graph, pass, listed ? in.list : CloudPixelList{}, 256);
    const gpu::ComputePipeline& applier = pipeline(froxel ? froxel_apply : apply, 0, 0, part, listed);
    const auto dispatch = [listed, extent = frame.extent](gpu::Commands& cmd) {
      if (listed)
        cmd.dispatch_indirect();
      else
        cmd.dispatch_threads(extent.width, extent.height);
    };
    if (froxel) {
      pass.sample("froxel_change", in.froxels.change);
      const shared::FroxelApplyPush push{in.froxels.data, has_clouds};
      pass.record([&applier, push, dispatch](gpu::Commands& cmd) { dispatch(cmd.bind(applier).push(push)); });
      return;
    }
    pass.sample("near_tex", blocks.near, Sampler::nearest_clamp)
        .sample("far_tex", blocks.far, Sampler::nearest_clamp)
        .sample("cloud_near_tex", blocks.cloud_near, Sampler::nearest_clamp)
        .sample("cloud_far_tex", blocks.cloud_far, Sampler::nearest_clamp)
        .sample("depths_tex", blocks.depths, Sampler::nearest_clamp);
    const shared::ShaftApplyPush push{block_of(frame, params, layers, air.sequence), has_clouds,
                                      scaled_top(changed_top_m(shade_of(params, method, air), layers))};
    pass.record([&applier, push, dispatch](gpu::Commands& cmd) { dispatch(cmd.bind(applier).push(push)); });
  };
  add_part(in.list ? background_part : all_parts);
  if (in.list) add_part(cloud_part);
  return {background, in.cloud ? cloud : ImageRef{}};
}

}  // namespace nepho
