#include "clouds/light_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "clouds/cloud_bounds.h"
#include "clouds/cloud_grid_bake.comp.h"
#include "clouds/cloud_grid_most.comp.h"
#include "clouds/cloud_grid_sun.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

constexpr float kShift = 0.9f;          ///< of maps ahead of the camera, in halves of their sides, at most
constexpr float kLooksAhead_m = 15e3f;  ///< cameras higher up look at the middle of the maps (cloud_region())
constexpr uint32_t kRowStep = 8;        ///< rows of a workgroup

/// Differences from which on a grid is made anew, a part each frame; and at once.
constexpr double kAgedVoxels = 2.0, kWrongHalves = 0.5;     ///< ways of its middle: voxels, halves of the finest level
constexpr double kAgedWindVoxels = 0.25, kWrongWind = 4.0;  ///< ways of the clouds, voxels
constexpr double kAgedSun_rad = 0.0017, kWrongSun_rad = 0.009;
constexpr double kWrongTurn_rad = 0.1;  ///< of the camera, where a grid has what is seen alone
constexpr float kAgedShift = 0.25f;   ///< of levels ahead of the camera, halves of their sides
constexpr float kWrongScale = 1.25f;  ///< ratio of the maps' sizes

/// Of the frames of a round those that fill in extinction; one spreads the largest, the rest trace sunlight.
uint32_t bake_frames(uint32_t round_frames) { return std::max(round_frames * 3 / 8, 1u); }

double angle_between(const glm::vec3& a, const glm::vec3& b) {
  const glm::dvec3 u = normalize(glm::dvec3(a)), v = normalize(glm::dvec3(b));
  return 2.0 * std::asin(std::min(0.5 * length(u - v), 1.0));
}

/// Part `step` of `steps` of `count`, in multiples of `of`.
uint32_t part(uint32_t count, uint32_t step, uint32_t steps, uint32_t of) {
  const uint32_t units = (count + of - 1) / of;
  return std::min(units * step / steps * of, count);
}

}  // namespace

LightGrid::LightGrid(gpu::Device& device, const Clouds& clouds, const Layout& layout)
    : device_(device),
      clouds_(clouds),
      layout_(layout),
      sun_(device, {.name = "clouds.grid_sun", .spirv = cloud_grid_sun_comp}),
      spread_{
          gpu::ComputePipeline(device, {.name = "clouds.most_x", .spirv = cloud_grid_most_comp, .constants = {0}}),
          gpu::ComputePipeline(device, {.name = "clouds.most_y", .spirv = cloud_grid_most_comp, .constants = {1}}),
          gpu::ComputePipeline(device, {.name = "clouds.most_z", .spirv = cloud_grid_most_comp, .constants = {2}})} {
  fastest_mps_ = std::abs(clouds.params().weather.drift_east_mps);
  for (const CloudLayer& layer : clouds.params().layers)
    fastest_mps_ = std::max(fastest_mps_, std::hypot(layer.wind_east_mps, layer.wind_north_mps));
}

void LightGrid::renew() {
  for (Grid& grid : grids_) grid.filled = false;
  round_.reset();
}

shared::RegionMap LightGrid::region(const FrameInfo& frame) const {
  constexpr float kHalf_px = 32.0f;  // no finer maps than that many pixels far away
  double top_m = 0.0;
  for (const Clouds::HeightRange& r : clouds_.layer_ranges()) top_m = std::max(top_m, r.high_m);
  shared::RegionMap map = cloud_region(frame.constants, frame.camera_ecef_m, top_m);
  const float reach_m = map.half_m * std::exp2(static_cast<float>(map.levels - 1));
  const float above_m = std::max(frame.constants.planet.camera_height_m - static_cast<float>(top_m), 0.0f);
  map.half_m = std::max(layout_.finest_half_m, kHalf_px * frame.constants.pixel_angle_rad * above_m);
  // Two levels at least: they are layers of an array.
  map.levels =
      std::clamp(1u + static_cast<uint32_t>(std::ceil(std::log2(std::max(reach_m / map.half_m, 1.0f)))), 2u, 12u);
  return map;
}

shared::CloudGrid LightGrid::places(const FrameInfo& frame, bool all_around) const {
  const shared::CloudBounds bands = cloud_bands(clouds_, layout_.slices);
  shared::CloudGrid grid{};
  grid.map = region(frame);
  grid.band_low_m = bands.band_low_m;
  grid.band_high_m = bands.band_high_m;
  grid.band_first = bands.band_first;
  grid.band_slices = bands.band_slices;
  grid.bands = bands.bands;
  grid.texels = layout_.texels;
  grid.all_around = all_around ? 1 : 0;
  grid.slices = layout_.slices;
  // Maps lie ahead of a camera that looks along the ground.
  if (!layout_.all_around && frame.constants.planet.camera_height_m < kLooksAhead_m) {
    const glm::vec3 forward = normalize(frame.constants.forward);
    const float step = static_cast<float>(layout_.texels) / 4.0f;
    const float inner = 1.0f - 2.0f * (shared::kMostVoxels + 1.0f) / static_cast<float>(layout_.texels);
    const float most = std::floor(std::min(kShift, inner - 0.05f) * step);
    grid.shift =
        clamp(round(glm::vec2(dot(forward, grid.map.east), dot(forward, grid.map.north)) * most), -most, most) / step;
  }
  return grid;
}

LightGrid::Key LightGrid::key_of(const FrameInfo& frame, bool all_around) const {
  return {.camera_ecef_m = frame.camera_ecef_m,
          .time_s = frame.time_s,
          .key_dir = frame.constants.key_dir,
          .forward = layout_.all_around ? glm::vec3(0.0f) : frame.constants.forward,
          .all_around = all_around};
}

LightGrid::Fit LightGrid::fit(const Grid& grid, const Key& now, const shared::CloudGrid& wanted) const {
  if (!grid.filled) return Fit::wrong;
  if (grid.key == now) return Fit::good;
  // A still's has little outside of its view: it serves while another is made.
  const bool narrow = !grid.key.all_around;
  if (narrow) {
    Key as_still = now;
    as_still.all_around = false;
    if (grid.key == as_still) return Fit::good;
    if (angle_between(grid.key.forward, now.forward) > kWrongTurn_rad) return Fit::wrong;
  }
  const shared::CloudGrid& has = grid.places;
  const double half_m = static_cast<double>(has.map.half_m), voxel_m = 2.0 * half_m / has.texels;
  const double moved_m = static_cast<double>(has.map.radius_m * distance(has.map.centre, wanted.map.centre));
  const double wind_m = fastest_mps_ * std::abs(now.time_s - grid.key.time_s);
  const double sun_rad = angle_between(grid.key.key_dir, now.key_dir);
  const float scale = std::max(has.map.half_m / wanted.map.half_m, wanted.map.half_m / has.map.half_m);
  if (moved_m > kWrongHalves * half_m || wind_m > kWrongWind * voxel_m || sun_rad > kWrongSun_rad ||
      scale > kWrongScale)
    return Fit::wrong;
  const bool turned = distance(has.shift, wanted.shift) > kAgedShift;
  const bool aged = moved_m > kAgedVoxels * voxel_m || wind_m > kAgedWindVoxels * voxel_m || sun_rad > kAgedSun_rad;
  return aged || turned || narrow ? Fit::aged : Fit::good;
}

void LightGrid::prepare(Grid& grid, const Key& key, const shared::CloudGrid& places) {
  const Extent3D extent{places.texels, places.texels, places.slices * places.map.levels};
  const Extent3D half{places.texels / 2, places.texels / 2, extent.depth / 2};
  if (!grid.grid || !(grid.grid.desc().extent == extent)) {
    grid.extinction =
        device_.create_image({.name = "clouds.grid_extinction", .extent = extent, .format = Format::rgba16f});
    grid.grid = device_.create_image({.name = "clouds.grid", .extent = extent, .format = Format::rgba16f});
    grid.most = device_.create_image({.name = "clouds.grid_most", .extent = half, .format = Format::r16f});
  }
  grid.places = places;
  grid.key = key;
  grid.filled = false;
}

void LightGrid::add_bake(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, BufferRef data,
                         Grid& grid, Range rows) {
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = bake_[phases - 1];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(
        device_, {.name = "clouds.grid", .spirv = cloud_grid_bake_comp, .constants = clouds_.specialisation(phases)});
  auto bake = graph.pass("clouds.grid");
  bake.uniform("frame", frame.buffer)
      .uniform("light", data)
      .read_write("out_grid", graph.import(grid.extinction))
      .effect();
  bind_density(bake, density);
  bake.record([&pipeline, side = grid.places.texels, rows](gpu::Commands& cmd) {
    struct BakePush {
      uint32_t level, first_row;
    };
    cmd.bind(pipeline);
    // Level after level: a coarse one takes means of the finer.
    for (uint32_t row = rows.first; row < rows.end;) {
      const uint32_t level = row / side, end = std::min(rows.end, (level + 1) * side);
      cmd.push(BakePush{level, row - level * side}).dispatch_threads(side, end - row).barrier();
      row = end;
    }
  });
}

void LightGrid::add_most(FrameGraph& graph, BufferRef data, Grid& grid) {
  const Extent3D half = grid.most.desc().extent;
  const ImageRef spread_x = graph.create("clouds.grid_most_x", {.extent = half, .format = Format::r16f});
  const ImageRef spread_y = graph.create("clouds.grid_most_y", {.extent = half, .format = Format::r16f});
  const std::array<ImageRef, 4> chain{graph.import(grid.extinction), spread_x, spread_y, graph.import(grid.most)};
  for (size_t axis = 0; axis < 3; ++axis) {
    auto spread = graph.pass("clouds.grid_most");
    spread.uniform("light", data).sample("in_tex", chain[axis]).write("out_most", chain[axis + 1]).effect();
    spread.record([this, axis, half](gpu::Commands& cmd) {
      cmd.bind(spread_[axis]).dispatch_threads(half.width, half.height, half.depth);
    });
  }
}

void LightGrid::add_sun(FrameGraph& graph, const FrameInfo& frame, BufferRef data, Grid& grid, Range planes) {
  auto sun = graph.pass("clouds.grid_sun");
  sun.uniform("frame", frame.buffer)
      .uniform("light", data)
      .sample("grid_tex", graph.import(grid.extinction))
      .sample("most_tex", graph.import(grid.most))
      .write("out_grid", graph.import(grid.grid))
      .effect();
  sun.record([this, side = grid.places.texels, planes](gpu::Commands& cmd) {
    cmd.bind(sun_).push(planes.first).dispatch_threads(side, side, planes.end - planes.first);
  });
}

void LightGrid::advance_round(FrameGraph& graph) {
  Round& round = *round_;
  Grid& back = grids_[1 - front_];
  FrameInfo frame = round.frame;
  frame.buffer = graph.constants("clouds.grid_frame", frame.constants);
  const BufferRef data = graph.constants("clouds.grid_data", round.constants);
  const uint32_t bakes = bake_frames(layout_.round_frames), suns = std::max(layout_.round_frames - bakes, 2u) - 1u;
  if (round.step < bakes) {
    const uint32_t rows = back.places.texels * back.places.map.levels;
    const Range range{part(rows, round.step, bakes, kRowStep), part(rows, round.step + 1, bakes, kRowStep)};
    if (range.first < range.end) add_bake(graph, frame, import_cloud_density(graph, frame, clouds_), data, back, range);
  } else if (round.step == bakes) {
    add_most(graph, data, back);
  } else {
    const uint32_t planes = back.places.slices * back.places.map.levels, step = round.step - bakes - 1;
    const Range range{part(planes, step, suns, 1), part(planes, step + 1, suns, 1)};
    if (range.first < range.end) add_sun(graph, frame, data, back, range);
  }
  if (++round.step < bakes + 1 + suns) return;
  back.filled = true;
  front_ = 1 - front_;  // its last part runs before this frame reads it
  round_.reset();
}

LightGrid::Refs LightGrid::add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density,
                               bool sequence, const shared::CloudLightConstants& constants) {
  const bool all_around = sequence || layout_.all_around;
  const shared::CloudGrid wanted = places(frame, all_around);
  const Key now = key_of(frame, all_around);
  Fit found = fit(grids_[front_], now, wanted);
  if (!sequence) {
    round_.reset();
    if (!(grids_[front_].key == now)) found = Fit::wrong;
  }
  if (found == Fit::wrong) {
    round_.reset();
    Grid& front = grids_[front_];
    prepare(front, now, wanted);
    shared::CloudLightConstants whole = constants;
    whole.grid = wanted;
    const BufferRef data = graph.constants("clouds.grid_data", whole);
    add_bake(graph, frame, density, data, front, {0, wanted.texels * wanted.map.levels});
    add_most(graph, data, front);
    add_sun(graph, frame, data, front, {0, wanted.slices * wanted.map.levels});
    front.filled = true;
  } else if (found == Fit::aged && !round_) {
    prepare(grids_[1 - front_], now, wanted);
    round_ = Round{.frame = frame, .constants = constants, .step = 0};
    round_->constants.grid = wanted;
  }
  if (round_) advance_round(graph);
  Grid& front = grids_[front_];
  return {.places = front.places, .grid = graph.import(front.grid), .most = graph.import(front.most)};
}

}  // namespace nepho
