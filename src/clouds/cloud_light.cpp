#include "clouds/cloud_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "clouds/beam_table.h"
#include "clouds/cloud_bounds.h"
#include "clouds/cloud_grid_bake.comp.h"
#include "clouds/cloud_grid_most.comp.h"
#include "clouds/cloud_grid_sun.comp.h"
#include "clouds/light_gather.comp.h"
#include "clouds/light_ground_smooth.comp.h"
#include "clouds/light_list.comp.h"
#include "clouds/light_mark.comp.h"
#include "clouds/light_sky.comp.h"
#include "clouds/light_smooth.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

constexpr float kGrowths = 5.76f;       ///< of cells along a ray, all together: the last ends some 500 km away
constexpr float kShift = 0.9f;          ///< of maps ahead of the camera, in halves of their sides, at most
constexpr float kLooksAhead_m = 15e3f;  ///< cameras higher up look at the middle of the maps (cloud_region())
shared::LightCells cells_for(Extent2D extent, const CloudLight::Quality& quality, float first_m) {
  const uint32_t longest = std::max(extent.width, extent.height);
  const double px = std::max(double{quality.node_px}, static_cast<double>(longest) / quality.most_nodes);
  shared::LightCells c{};
  c.nodes = {std::max(2u, static_cast<uint32_t>(std::lround(extent.width / px))),
             std::max(2u, static_cast<uint32_t>(std::lround(extent.height / px)))};
  c.slices = quality.slices;
  c.paths = quality.paths;
  c.path_step = std::max(1u, static_cast<uint32_t>(0.618 * quality.paths));
  while (std::gcd(c.path_step, c.paths) != 1) ++c.path_step;
  c.first_m = first_m;
  c.growth = kGrowths / static_cast<float>(c.slices);
  c.log2_ratio = std::log2(1.0f + c.growth);
  c.smooth_m = quality.smooth_m;
  c.smooth_paths = quality.smooth_paths;
  c.stride_px = std::max(1u, static_cast<uint32_t>(px / 2.0));
  return c;
}

shared::CloudGrid grid_places(const Clouds& clouds, const shared::RegionMap& map, const CloudLight::Quality& quality) {
  const shared::CloudBounds bands = cloud_bands(clouds, quality.grid_slices);
  shared::CloudGrid grid{};
  grid.map = map;
  grid.band_low_m = bands.band_low_m;
  grid.band_high_m = bands.band_high_m;
  grid.band_first = bands.band_first;
  grid.band_slices = bands.band_slices;
  grid.bands = bands.bands;
  grid.texels = quality.grid_texels;
  grid.all_around = quality.all_around ? 1 : 0;
  grid.slices = quality.grid_slices;
  return grid;
}

}  // namespace

CloudLight::Quality CloudLight::quality_of(const std::string& preset) {
  if (preset == "ultra") return {.paths = 48, .node_px = 2, .most_nodes = 160, .grid_texels = 256, .grid_slices = 96};
  if (preset == "medium")
    return {.paths = 6,
            .node_px = 8,
            .most_nodes = 32,
            .grid_texels = 96,
            .grid_slices = 24,
            .slices = 192,
            .first_m = 50.0f,
            .smooth_m = 100.0f,
            .smooth_paths = 1.0f,
            .smooth_passes = 2};
  return {};
}

CloudLight::CloudLight(gpu::Device& device, const Clouds& clouds, uint32_t spectral_groups, const Quality& quality)
    : device_(device),
      clouds_(clouds),
      quality_(quality),
      sun_(device, {.name = "clouds.grid_sun", .spirv = cloud_grid_sun_comp}),
      spread_{gpu::ComputePipeline(device, {.name = "clouds.most_x", .spirv = cloud_grid_most_comp, .constants = {0}}),
              gpu::ComputePipeline(device, {.name = "clouds.most_y", .spirv = cloud_grid_most_comp, .constants = {1}}),
              gpu::ComputePipeline(device, {.name = "clouds.most_z", .spirv = cloud_grid_most_comp, .constants = {2}})},
      mark_(device, {.name = "clouds.light_mark", .spirv = light_mark_comp}),
      list_(device, {.name = "clouds.light_list", .spirv = light_list_comp}),
      gather_(device, {.name = "clouds.light_gather", .spirv = light_gather_comp, .constants = {0}}),
      gather_ground_(device, {.name = "clouds.light_ground", .spirv = light_gather_comp, .constants = {1}}),
      smooth_(device, {.name = "clouds.light_smooth", .spirv = light_smooth_comp}),
      smooth_ground_(device, {.name = "clouds.light_ground_smooth", .spirv = light_ground_smooth_comp}),
      sky_(device, {.name = "clouds.light_sky", .spirv = light_sky_comp, .constants = {spectral_groups}}) {
  beam_ = device.create_image(
      {.name = "clouds.beam", .extent = {shared::kBeamTexels, shared::kBeamOrders / 4}, .format = Format::rgba32f});
  no_albedo_ =
      device.create_image({.name = "clouds.no_albedo", .extent = {2, 2}, .format = Format::rgba16f, .layers = 2});
  no_height_ = device.create_image({.name = "clouds.no_height", .extent = {2, 2}, .format = Format::r32f, .layers = 2});
  const std::vector<std::byte> zeros(64);
  std::vector<uint16_t> black_land(16, 0);  // alpha is the share of land
  for (size_t i = 3; i < black_land.size(); i += 4) black_land[i] = 0x3c00;
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t layer = 0; layer < 2; ++layer) {
    uploads.push_back({.image = &no_albedo_, .bytes = std::as_bytes(std::span(black_land)), .layer = layer});
    uploads.push_back({.image = &no_height_, .bytes = std::span(zeros).first(16), .layer = layer});
  }
  none_ = device.create_image({.name = "clouds.no_light", .extent = {1, 1, 2}, .format = Format::rgba16f});
  uploads.push_back({.image = &none_, .bytes = std::span(zeros).first(16)});
  const float one = 1.0f;
  even_sky_ = device.create_image({.name = "clouds.even_sky", .extent = {1, 1}, .format = Format::r32f});
  uploads.push_back({.image = &even_sky_, .bytes = std::as_bytes(std::span(&one, 1))});
  device.upload(uploads);
  renew(clouds.params());
}

void CloudLight::renew(const CloudParams& params) {
  filled_ = false;
  traced_ = params.multiple_scattering != "octaves";
  const double extinction_per_m = params.scattering_per_m + params.absorption_per_m;
  albedo_ = extinction_per_m > 0.0 ? static_cast<float>(params.scattering_per_m / extinction_per_m) : 1.0f;
  first_m_ = quality_.first_m;
  if (quality_.first_paths > 0.0f && extinction_per_m > 0.0)
    first_m_ = std::min(first_m_, quality_.first_paths / static_cast<float>(extinction_per_m));
  const DropletPhase phase = droplet_phase(params);
  const PhaseCut cut = cut_phase(phase.moment(1), phase.moment(4));
  forward_share_ = static_cast<float>(cut.forward_share);
  wide_g_ = static_cast<float>(cut.wide_g);
  const std::vector<float> table =
      beam_table(phase, cut, shared::kBeamTexels, shared::kBeamOrders, params.multiple_scattering_weight);
  const gpu::ImageUpload upload{.image = &beam_, .bytes = std::as_bytes(std::span(table))};
  device_.upload({&upload, 1});
}

shared::RegionMap CloudLight::region(const FrameInfo& frame) const {
  constexpr float kHalf_px = 32.0f;  // no finer maps than that many pixels far away
  double top_m = 0.0;
  for (const Clouds::HeightRange& r : clouds_.layer_ranges()) top_m = std::max(top_m, r.high_m);
  shared::RegionMap map = cloud_region(frame.constants, frame.camera_ecef_m, top_m);
  const float reach_m = map.half_m * std::exp2(static_cast<float>(map.levels - 1));
  const float above_m = std::max(frame.constants.planet.camera_height_m - static_cast<float>(top_m), 0.0f);
  map.half_m = std::max(quality_.finest_half_m, kHalf_px * frame.constants.pixel_angle_rad * above_m);
  // Two levels at least: they are layers of an array.
  map.levels =
      std::clamp(1u + static_cast<uint32_t>(std::ceil(std::log2(std::max(reach_m / map.half_m, 1.0f)))), 2u, 12u);
  return map;
}

void CloudLight::add_grid(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, BufferRef data,
                          const shared::CloudGrid& places) {
  const uint32_t side = places.texels, levels = places.map.levels;
  const Extent3D extent{side, side, places.slices * levels};
  const Extent3D half{side / 2, side / 2, extent.depth / 2};
  if (!grid_ || !(grid_.desc().extent == extent)) {
    extinction_ = device_.create_image({.name = "clouds.grid_extinction", .extent = extent, .format = Format::rgba16f});
    grid_ = device_.create_image({.name = "clouds.grid", .extent = extent, .format = Format::rgba16f});
    most_ = device_.create_image({.name = "clouds.grid_most", .extent = half, .format = Format::r16f});
  }
  const ImageRef extinction = graph.import(extinction_), grid = graph.import(grid_), most = graph.import(most_);
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = bake_[phases - 1];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(
        device_, {.name = "clouds.grid", .spirv = cloud_grid_bake_comp, .constants = clouds_.specialisation(phases)});
  auto bake = graph.pass("clouds.grid");
  bake.uniform("frame", frame.buffer).uniform("light", data).read_write("out_grid", extinction).effect();
  bind_density(bake, density);
  bake.record([&pipeline, side, levels](gpu::Commands& cmd) {
    cmd.bind(pipeline);
    for (uint32_t level = 0; level < levels; ++level) cmd.push(level).dispatch_threads(side, side).barrier();
  });
  const ImageRef spread_x = graph.create("clouds.grid_most_x", {.extent = half, .format = Format::r16f});
  const ImageRef spread_y = graph.create("clouds.grid_most_y", {.extent = half, .format = Format::r16f});
  const std::array<ImageRef, 4> chain{extinction, spread_x, spread_y, most};
  for (size_t axis = 0; axis < 3; ++axis) {
    auto spread = graph.pass("clouds.grid_most");
    spread.uniform("light", data).sample("in_tex", chain[axis]).write("out_most", chain[axis + 1]).effect();
    spread.record([this, axis, half](gpu::Commands& cmd) {
      cmd.bind(spread_[axis]).dispatch_threads(half.width, half.height, half.depth);
    });
  }
  auto sun = graph.pass("clouds.grid_sun");
  sun.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("grid_tex", extinction)
      .sample("most_tex", most)
      .write("out_grid", grid)
      .effect();
  sun.record([this, extent](gpu::Commands& cmd) {
    cmd.bind(sun_).dispatch_threads(extent.width, extent.height, extent.depth);
  });
}

CloudLight::Refs CloudLight::add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) {
  const shared::RegionMap map = region(frame);
  shared::CloudLightConstants constants{};
  constants.grid = grid_places(clouds_, map, quality_);
  // Maps lie ahead of a camera that looks along the ground.
  if (!quality_.all_around && frame.constants.planet.camera_height_m < kLooksAhead_m) {
    const glm::vec3 forward = normalize(frame.constants.forward);
    const float step = static_cast<float>(quality_.grid_texels) / 4.0f;
    const float inner = 1.0f - 2.0f * (shared::kMostVoxels + 1.0f) / static_cast<float>(quality_.grid_texels);
    const float most = std::floor(std::min(kShift, inner - 0.05f) * step);
    constants.grid.shift =
        clamp(round(glm::vec2(dot(forward, map.east), dot(forward, map.north)) * most), -most, most) / step;
  }
  constants.ground = in.ground;
  if (!in.ground_albedo) {
    constants.ground = map;
    constants.ground.levels = 2;
  }
  const shared::LightCells cells = constants.cells = cells_for(frame.extent, quality_, first_m_);
  const float albedo = albedo_;
  constants.forward_share = forward_share_;
  constants.wide_g = wide_g_;
  constants.forward_albedo = albedo * forward_share_;
  constants.wide_albedo = albedo * (1.0f - forward_share_) / (1.0f - constants.forward_albedo);
  constants.seed = frame.constants.seed;
  constants.frame_index = frame.constants.frame_index;
  const BufferRef data = graph.constants("clouds.light_data", constants);
  const Key key{.camera_ecef_m = frame.camera_ecef_m,
                .time_s = frame.time_s,
                .key_dir = frame.constants.key_dir,
                .forward = quality_.all_around ? glm::vec3(0.0f) : frame.constants.forward};
  const bool terrain = static_cast<bool>(in.terrain_shadow);
  const ImageRef terrain_shadow = terrain ? in.terrain_shadow : graph.import(no_height_);
  const BufferRef terrain_map = terrain ? in.terrain_map : graph.constants("clouds.no_terrain", map);
  if (!traced_) {  // bound, never read
    const ImageRef none = graph.import(none_);
    return {.data = data,
            .grid = none,
            .most = none,
            .cells = none,
            .ground = {},
            .nodes = {},
            .terrain_shadow = terrain_shadow,
            .terrain_map = terrain_map,
            .terrain = terrain,
            .beam = graph.import(beam_)};
  }
  if (!filled_ || !(key == key_)) {
    add_grid(graph, frame, in.density, data, constants.grid);
    key_ = key;
    filled_ = true;
  }
  const ImageRef grid = graph.import(grid_);

  const uint32_t words = cells.nodes.x * cells.nodes.y * cells.slices / 32;
  const BufferRef marks = graph.create_buffer("clouds.light_marks", uint64_t{words} * 4);
  const BufferRef work = graph.create_buffer("clouds.light_work", sizeof(shared::LightWork));
  const BufferRef list = graph.create_buffer("clouds.light_list", uint64_t{words} * 32 * 4);
  const ImageDesc desc{.extent = {cells.nodes.x, cells.nodes.y, cells.slices}, .format = Format::rgba16f};
  const ImageRef traced = graph.create("clouds.light_traced", desc), out = graph.create("clouds.light_cells", desc);
  auto clear = graph.pass("clouds.light_clear");
  clear.zero("marks", marks).zero("work", work).fill("traced", traced).fill("out_cells", out);
  clear.record([](gpu::Commands& cmd) { cmd.zero("marks").zero("work").fill("traced", 0.0f).fill("out_cells", 0.0f); });
  auto mark = graph.pass("clouds.light_mark");
  mark.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("grid_tex", grid)
      .sample("most_tex", graph.import(most_), Sampler::nearest_clamp)
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .read_write("marks", marks);
  mark.record([this, extent = frame.extent, px = cells.stride_px](gpu::Commands& cmd) {
    cmd.bind(mark_).dispatch_threads((extent.width + px - 1) / px, (extent.height + px - 1) / px);
  });
  auto collect = graph.pass("clouds.light_list");
  collect.uniform("light", data).read("marks", marks).read_write("work", work).write("list", list);
  collect.record([this, words](gpu::Commands& cmd) { cmd.bind(list_).dispatch_threads(words); });
  ImageRef sky = graph.import(even_sky_);
  if (in.atmosphere) {
    sky = graph.create("clouds.light_sky",
                       {.extent = {shared::kLightSkyTexels, shared::kLightSkyTexels}, .format = Format::r32f});
    auto pass = graph.pass("clouds.light_sky");
    pass.uniform("frame", frame.buffer).write("out_sky", sky);
    AtmosphereTables::bind(pass, *in.atmosphere);
    struct SkyPush {
      glm::vec3 up;
      float height_m;
    };
    const glm::vec3 up =
        normalize(glm::vec3(map.centre.x, map.centre.y, map.centre.z * frame.constants.planet.a_over_b));
    const SkyPush push{up, 0.5f * (clouds_.constants().hull_low_m + clouds_.constants().hull_high_m)};
    pass.record([this, push](gpu::Commands& cmd) {
      cmd.bind(sky_).push(push).dispatch_threads(shared::kLightSkyTexels, shared::kLightSkyTexels);
    });
  }
  const ImageRef ground =
      graph.create("clouds.light_ground", {.extent = {cells.nodes.x, cells.nodes.y}, .format = Format::rgba32f});
  for (const bool surface : {false, true}) {
    auto gather = graph.pass(surface ? "clouds.light_ground" : "clouds.light_gather");
    gather.uniform("frame", frame.buffer)
        .uniform("light", data)
        .uniform("cloud", in.density.constants)
        .sample("grid_tex", grid)
        .sample("most_tex", graph.import(most_), Sampler::nearest_clamp)
        .sample("sky_tex", sky)
        .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
        .sample("ground_albedo_tex", in.ground_albedo ? in.ground_albedo : graph.import(no_albedo_))
        .sample("ground_height_tex", in.ground_height ? in.ground_height : graph.import(no_height_))
        .sample("terrain_volume_tex", terrain_shadow)
        .uniform("terrain_volume", terrain_map)
        .read("work", work)
        .read("list", list)
        .write("out_cells", traced)
        .write("out_ground", ground);
    const uint32_t threads = surface ? cells.nodes.x * cells.nodes.y : words * 32;
    gpu::ComputePipeline& shaded = gather_terrain_[surface ? 1 : 0];
    if (terrain && !shaded)
      shaded = gpu::ComputePipeline(device_, {.name = surface ? "clouds.light_ground" : "clouds.light_gather",
                                              .spirv = light_gather_comp,
                                              .constants = {surface ? 1u : 0u, 1u}});
    const gpu::ComputePipeline& pipeline = terrain ? shaded : surface ? gather_ground_ : gather_;
    gather.record([&pipeline, threads](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(threads); });
  }
  const ImageRef even_ground =
      graph.create("clouds.light_even_ground", {.extent = {cells.nodes.x, cells.nodes.y}, .format = Format::rgba32f});
  auto even = graph.pass("clouds.light_ground_smooth");
  even.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("in_ground", ground, Sampler::nearest_clamp)
      .write("out_ground", even_ground);
  even.record(
      [this, nodes = cells.nodes](gpu::Commands& cmd) { cmd.bind(smooth_ground_).dispatch_threads(nodes.x, nodes.y); });
  // Each mean spreads twice as far as the one before.
  ImageRef from = traced, to = out;
  for (uint32_t i = 0; i < quality_.smooth_passes; ++i) {
    if (i > 0) std::swap(from, to);
    auto smooth = graph.pass("clouds.light_smooth");
    smooth.uniform("frame", frame.buffer)
        .uniform("light", data)
        .read("work", work)
        .read("list", list)
        .sample("in_cells", from, Sampler::nearest_clamp)
        .sample("grid_tex", grid)
        .sample("most_tex", graph.import(most_), Sampler::nearest_clamp)
        .write("out_cells", to);
    smooth.record([this, words, stride = int32_t{1} << i](gpu::Commands& cmd) {
      cmd.bind(smooth_).push(stride).dispatch_threads(words * 32);
    });
  }
  return {.data = data,
          .grid = grid,
          .most = graph.import(most_),
          .cells = to,
          .ground = even_ground,
          .nodes = cells.nodes,
          .terrain_shadow = terrain_shadow,
          .terrain_map = terrain_map,
          .terrain = terrain,
          .beam = graph.import(beam_)};
}

}  // namespace nepho
