#include "clouds/cloud_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "clouds/beam_table.h"
#include "clouds/light_args.comp.h"
#include "clouds/light_clear.comp.h"
#include "clouds/light_gather.comp.h"
#include "clouds/light_ground_history.comp.h"
#include "clouds/light_ground_smooth.comp.h"
#include "clouds/light_history.comp.h"
#include "clouds/light_list.comp.h"
#include "clouds/light_mark.comp.h"
#include "clouds/light_sky.comp.h"
#include "clouds/light_smooth.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

constexpr float kGrowths = 5.76f;  ///< of cells along a ray, all together: the last ends some 500 km away

/// Differences between frames that make a cut: light is traced anew.
constexpr double kCutWind_m = 30.0, kCutSun_rad = 0.0035;
constexpr double kCutMove_m = 300.0, kCutMoveOfHeight = 0.01;  ///< the larger

shared::LightCells cells_for(Extent2D extent, const CloudLight::Quality& quality, float first_m) {
  const uint32_t longest = std::max(extent.width, extent.height);
  const double px = std::max(static_cast<double>(quality.node_px), static_cast<double>(longest) / quality.most_nodes);
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
  c.refresh_frames = quality.refresh_frames;
  c.deepest = quality.deepest;
  return c;
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

CloudLight::Quality CloudLight::live_quality_of(const std::string& preset, bool software) {
  Quality q = quality_of(preset);
  q.paths = std::min(q.paths, software ? 6u : 8u);
  q.most_nodes = std::min(q.most_nodes, software ? 40u : 64u);
  q.slices = std::min(q.slices, software ? 96u : 192u);
  q.first_m = software ? 100.0f : 50.0f;
  q.smooth_m = 400.0f;  // nodes of thin clouds are far apart, and their light varies little
  q.smooth_paths = 1.0f;
  q.deepest = 24.0f;
  q.grid_texels = std::min(q.grid_texels, software ? 96u : 192u);
  q.grid_slices = std::min(q.grid_slices, software ? 48u : 96u);
  q.refresh_frames = software ? 32 : 8;
  q.round_frames = software ? 96 : 32;
  return q;
}

CloudLight::CloudLight(gpu::Device& device, const Clouds& clouds, uint32_t spectral_groups, const Quality& quality)
    : device_(device),
      clouds_(clouds),
      quality_(quality),
      grid_(device, clouds,
            {.texels = quality.grid_texels,
             .slices = quality.grid_slices,
             .finest_half_m = quality.finest_half_m,
             .all_around = quality.all_around,
             .round_frames = quality.round_frames}),
      clear_(device, {.name = "clouds.light_clear", .spirv = light_clear_comp}),
      mark_(device, {.name = "clouds.light_mark", .spirv = light_mark_comp}),
      list_(device, {.name = "clouds.light_list", .spirv = light_list_comp}),
      smooth_(device, {.name = "clouds.light_smooth", .spirv = light_smooth_comp}),
      smooth_ground_(device, {.name = "clouds.light_ground_smooth", .spirv = light_ground_smooth_comp}),
      sky_(device, {.name = "clouds.light_sky", .spirv = light_sky_comp, .constants = {spectral_groups}}),
      history_(device, {.name = "clouds.light_history", .spirv = light_history_comp}),
      ground_history_(device, {.name = "clouds.light_ground_history", .spirv = light_ground_history_comp}),
      args_(device, {.name = "clouds.light_args", .spirv = light_args_comp}) {
  work_ = device.create_buffer({.name = "clouds.light_work", .size_bytes = sizeof(shared::LightWork)});
  fastest_mps_ = std::abs(clouds.params().weather.drift_east_mps);
  for (const CloudLayer& layer : clouds.params().layers)
    fastest_mps_ = std::max(fastest_mps_, std::hypot(layer.wind_east_mps, layer.wind_north_mps));
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
  grid_.renew();
  before_.reset();
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

void CloudLight::set_history(shared::CloudLightConstants& constants, const FrameInfo& frame, bool sequence) const {
  constants.keep = 0.0f;
  constants.most_weight = std::max(static_cast<float>(quality_.most_paths) / static_cast<float>(quality_.paths), 2.0f);
  if (!sequence || !before_ || before_->frame.extent != frame.extent || before_->cells.nodes != constants.cells.nodes ||
      before_->cells.first_m != constants.cells.first_m)
    return;
  const FrameInfo& before = before_->frame;
  const glm::dvec3 moved_m = frame.camera_ecef_m - before.camera_ecef_m;
  const double wind_m = fastest_mps_ * std::abs(frame.time_s - before.time_s);
  const double sun_rad = static_cast<double>(distance(frame.constants.key_dir, before.constants.key_dir));
  const double height_m = static_cast<double>(frame.constants.planet.camera_height_m);
  if (length(moved_m) > std::max(kCutMove_m, kCutMoveOfHeight * height_m) || wind_m > kCutWind_m ||
      sun_rad > kCutSun_rad)
    return;
  constants.moved_m = glm::vec3(moved_m);
  // Clouds that drift leave their light behind by as much.
  constants.keep = static_cast<float>(std::exp(-wind_m / static_cast<double>(quality_.smooth_m)));
  const shared::FrameConstants &a = frame.constants, &b = before.constants;
  constants.still = moved_m == glm::dvec3(0.0) && a.forward == b.forward && a.right == b.right && a.up == b.up ? 1 : 0;
}

ImageRef CloudLight::add_sky(FrameGraph& graph, const FrameInfo& frame, const AtmosphereTables::Refs& atmosphere,
                             const shared::RegionMap& map) {
  const ImageRef sky = graph.create(
      "clouds.light_sky", {.extent = {shared::kLightSkyTexels, shared::kLightSkyTexels}, .format = Format::r32f});
  auto pass = graph.pass("clouds.light_sky");
  pass.uniform("frame", frame.buffer).write("out_sky", sky);
  AtmosphereTables::bind(pass, atmosphere);
  struct SkyPush {
    glm::vec3 up;
    float height_m;
  };
  const glm::vec3 up = normalize(glm::vec3(map.centre.x, map.centre.y, map.centre.z * frame.constants.planet.a_over_b));
  const SkyPush push{up, 0.5f * (clouds_.constants().hull_low_m + clouds_.constants().hull_high_m)};
  pass.record([this, push](gpu::Commands& cmd) {
    cmd.bind(sky_).push(push).dispatch_threads(shared::kLightSkyTexels, shared::kLightSkyTexels);
  });
  return sky;
}

const gpu::ComputePipeline& CloudLight::gather(bool terrain, bool sequence, bool surface) {
  const uint32_t kind = (sequence ? 2u : 0u) + (surface ? 1u : 0u);
  gpu::ComputePipeline& pipeline = gather_[kind + (terrain ? 4u : 0u)];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(device_, {.name = surface ? "clouds.light_ground" : "clouds.light_gather",
                                              .spirv = light_gather_comp,
                                              .constants = {kind, terrain ? 1u : 0u}});
  return pipeline;
}

CloudLight::Work CloudLight::work() {
  const std::vector<std::byte> bytes = device_.download(work_);
  shared::LightWork w{};
  std::memcpy(&w, bytes.data(), sizeof(w));
  if (cut_)
    return {.cells = w.count, .fresh = w.count, .refresh = 0, .ground_fresh = 0, .ground_refresh = 0, .cut = true};
  return {.cells = w.count,
          .fresh = w.fresh,
          .refresh = w.refresh,
          .ground_fresh = w.ground_fresh,
          .ground_refresh = w.ground_refresh,
          .cut = false};
}

CloudLight::Refs CloudLight::add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) {
  const shared::RegionMap map = region(frame);
  shared::CloudLightConstants constants{};
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
  set_history(constants, frame, in.sequence);
  const bool sequence = constants.keep > 0.0f;
  const bool terrain = static_cast<bool>(in.terrain_shadow);
  const ImageRef terrain_shadow = terrain ? in.terrain_shadow : graph.import(no_height_);
  const BufferRef terrain_map = terrain ? in.terrain_map : graph.constants("clouds.no_terrain", map);
  if (!traced_) {  // bound, never read
    const BufferRef data = graph.constants("clouds.light_data", constants);
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
  const LightGrid::Refs places = grid_.add(graph, frame, in.density, sequence, constants);
  const ImageRef grid = places.grid, most = places.most;
  constants.grid = places.places;
  const BufferRef data = graph.constants("clouds.light_data", constants);

  const uint32_t words = cells.nodes.x * cells.nodes.y * cells.slices / 32;
  const BufferRef marks = graph.create_buffer("clouds.light_marks", uint64_t{words} * 4);
  const BufferRef work = graph.import(work_);
  const BufferRef list = graph.create_buffer("clouds.light_list", uint64_t{words} * 32 * 4);
  const ImageDesc desc{.extent = {cells.nodes.x, cells.nodes.y, cells.slices}, .format = Format::rgba16f};
  Traced& images = traced_images_[now_];
  const Traced& last = traced_images_[1 - now_];
  if (!images.cells || !(images.cells.desc().extent == desc.extent)) {
    const Extent3D flat{cells.nodes.x, cells.nodes.y, 1};
    images.cells = device_.create_image({.name = "clouds.light_traced", .extent = desc.extent});
    images.ground = device_.create_image({.name = "clouds.light_ground", .extent = flat, .format = Format::rgba32f});
    images.ground_weight =
        device_.create_image({.name = "clouds.light_ground_weight", .extent = flat, .format = Format::r32f});
  }
  const ImageRef traced = graph.import(images.cells), ground = graph.import(images.ground),
                 ground_weight = graph.import(images.ground_weight);
  std::vector<ImageRef> smoothed;
  for (uint32_t i = 0; i < std::min(quality_.smooth_passes, 2u); ++i)
    smoothed.push_back(graph.create("clouds.light_cells", desc));
  auto zero = graph.pass("clouds.light_clear");
  zero.zero("marks", marks).zero("work", work);
  zero.record([](gpu::Commands& cmd) { cmd.zero("marks").zero("work"); });
  std::vector<ImageRef> cleared = smoothed;
  cleared.push_back(traced);
  for (const ImageRef image : cleared) {
    auto clear = graph.pass("clouds.light_clear");
    clear.write("out_cells", image);
    clear.record([this, size = desc.extent](gpu::Commands& cmd) {
      cmd.bind(clear_).dispatch_threads(size.width, size.height, size.depth);
    });
  }
  auto mark = graph.pass("clouds.light_mark");
  mark.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("grid_tex", grid)
      .sample("most_tex", most, Sampler::nearest_clamp)
      .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
      .read_write("marks", marks);
  mark.record([this, extent = frame.extent, px = cells.stride_px](gpu::Commands& cmd) {
    cmd.bind(mark_).dispatch_threads((extent.width + px - 1) / px, (extent.height + px - 1) / px);
  });
  auto collect = graph.pass("clouds.light_list");
  collect.uniform("light", data).read("marks", marks).read_write("work", work).write("list", list);
  collect.record([this, words](gpu::Commands& cmd) { cmd.bind(list_).dispatch_threads(words); });
  const ImageRef sky = in.atmosphere ? add_sky(graph, frame, *in.atmosphere, map) : graph.import(even_sky_);
  const uint32_t node_count = cells.nodes.x * cells.nodes.y;
  struct Lists {
    BufferRef fresh, refresh, args;
  };
  std::array<Lists, 2> lists{Lists{list, list, {}}, Lists{list, list, {}}};  // of cells and of nodes on the ground
  if (sequence) {
    const BufferRef before = graph.constants("clouds.light_before", before_->frame.constants);
    for (const bool surface : {false, true}) {
      const uint64_t bytes = surface ? uint64_t{node_count} * 4 : uint64_t{words} * 32 * 4;
      Lists& to = lists[surface ? 1 : 0];
      to = {.fresh = graph.create_buffer("clouds.light_fresh", bytes),
            .refresh = graph.create_buffer("clouds.light_refresh", bytes),
            .args = graph.create_buffer("clouds.light_args", 12)};
      auto history = graph.pass(surface ? "clouds.light_ground_history" : "clouds.light_history");
      history.uniform("frame", frame.buffer)
          .uniform("before", before)
          .uniform("light", data)
          .read_write("work", work)
          .write("fresh", to.fresh)
          .write("refresh", to.refresh);
      if (surface)
        history.sample("before_ground", graph.import(last.ground), Sampler::nearest_clamp)
            .sample("before_weight", graph.import(last.ground_weight), Sampler::nearest_clamp)
            .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
            .write("out_ground", ground)
            .write("out_weight", ground_weight);
      else
        history.read("list", list)
            .sample("before_cells", graph.import(last.cells), Sampler::nearest_clamp)
            .write("out_cells", traced);
      history.record([this, surface, threads = surface ? node_count : words * 32](gpu::Commands& cmd) {
        cmd.bind(surface ? ground_history_ : history_).dispatch_threads(threads);
      });
    }
    auto args = graph.pass("clouds.light_args");
    args.uniform("light", data)
        .read("work", work)
        .write("cell_args", lists[0].args)
        .write("ground_args", lists[1].args)
        .record([this](gpu::Commands& cmd) { cmd.bind(args_).dispatch_threads(1); });
  }
  for (const bool surface : {false, true}) {
    const Lists& of = lists[surface ? 1 : 0];
    auto pass = graph.pass(surface ? "clouds.light_ground" : "clouds.light_gather");
    pass.uniform("frame", frame.buffer)
        .uniform("light", data)
        .uniform("cloud", in.density.constants)
        .sample("grid_tex", grid)
        .sample("most_tex", most, Sampler::nearest_clamp)
        .sample("sky_tex", sky)
        .sample("depth_m", in.depth_m, Sampler::nearest_clamp)
        .sample("ground_albedo_tex", in.ground_albedo ? in.ground_albedo : graph.import(no_albedo_))
        .sample("ground_height_tex", in.ground_height ? in.ground_height : graph.import(no_height_))
        .sample("terrain_volume_tex", terrain_shadow)
        .uniform("terrain_volume", terrain_map)
        .read("work", work)
        .read("list", of.fresh)
        .read("refresh", of.refresh)
        .read_write("out_cells", traced)
        .read_write("out_ground", ground)
        .read_write("out_weight", ground_weight);
    if (sequence) pass.indirect(of.args);
    const gpu::ComputePipeline& pipeline = gather(terrain, sequence, surface);
    pass.record([&pipeline, sequence, threads = surface ? node_count : words * 32](gpu::Commands& cmd) {
      cmd.bind(pipeline);
      if (sequence)
        cmd.dispatch_indirect();
      else
        cmd.dispatch_threads(threads);
    });
  }
  const ImageRef even_ground =
      graph.create("clouds.light_even_ground", {.extent = {cells.nodes.x, cells.nodes.y}, .format = Format::rgba32f});
  auto even = graph.pass("clouds.light_ground_smooth");
  even.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("in_ground", ground, Sampler::nearest_clamp)
      .sample("in_weight", ground_weight, Sampler::nearest_clamp)
      .write("out_ground", even_ground);
  even.record(
      [this, nodes = cells.nodes](gpu::Commands& cmd) { cmd.bind(smooth_ground_).dispatch_threads(nodes.x, nodes.y); });
  // Each mean spreads twice as far as the one before.
  ImageRef from = traced, to = traced;
  for (uint32_t i = 0; i < quality_.smooth_passes; ++i) {
    from = to;
    to = smoothed[i % 2];
    auto smooth = graph.pass("clouds.light_smooth");
    smooth.uniform("frame", frame.buffer)
        .uniform("light", data)
        .read("work", work)
        .read("list", list)
        .sample("in_cells", from, Sampler::nearest_clamp)
        .sample("grid_tex", grid)
        .sample("most_tex", most, Sampler::nearest_clamp)
        .write("out_cells", to);
    smooth.record([this, words, stride = int32_t{1} << i](gpu::Commands& cmd) {
      cmd.bind(smooth_).push(stride).dispatch_threads(words * 32);
    });
  }
  before_ = Before{.frame = frame, .cells = cells};
  cut_ = !sequence;
  now_ = 1 - now_;
  return {.data = data,
          .grid = grid,
          .most = most,
          .cells = to,
          .ground = even_ground,
          .nodes = cells.nodes,
          .terrain_shadow = terrain_shadow,
          .terrain_map = terrain_map,
          .terrain = terrain,
          .beam = graph.import(beam_)};
}

}  // namespace nepho
