#include "clouds/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "clouds/shadow_map_march.comp.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::ShadowCascade) == 48);
static_assert(sizeof(shared::ShadowMaps) == 64 + 4 * 48 + 4 * 2048);
static_assert(sizeof(shared::ShadowTileWork) == 16);
constexpr uint32_t kTile = shared::kShadowTile;

constexpr double kMargin = 1.06;          // of a new cascade over what it must serve, so that it lasts
constexpr double kWrong_texels = 0.5;     // clouds moved by so much: a tile is marched at once;
constexpr double kAged_texels = 0.1;      // by so much: in its turn
constexpr double kLargest = 1.4;          // a cascade this much larger than needed is made anew
constexpr double kLowestGround_m = -600;  // no ground that is seen lies lower
constexpr double kDetailHidden = 0.06;    // of the detail noise's period: texels that hide it
/// 4/pi of a cloud's height over its width, per thickness of a layer over the size of its cells: clouds are 0.6 of the
/// one high where they stand and the other wide (measured, docs/light.md, 'Shafts').
constexpr double kSlant = 0.75;
constexpr uint32_t kMostGroups = 60000;  // of a dispatch

struct MarchPush {
  uint32_t first;
  float step_scale;
  float footprint;
};

/// Mean share of light from the zenith that reaches the ground, for where no map is.
float mean_transmittance(const CloudParams& params) {
  const double covered = params.coverage.value_or(params.weather.mean_coverage_r);
  return static_cast<float>(1.0 - 0.9 * covered);
}

uint32_t place_of(int64_t tile, uint32_t tiles) {
  const int64_t n = tiles, m = tile % n;
  return static_cast<uint32_t>(m < 0 ? m + n : m);
}

}  // namespace

void bind_cloud_shadow(FrameGraph::PassBuilder& pass, const CloudShadowRefs& refs) {
  pass.uniform("cloud_shadow", refs.data).sample("cloud_shadow_map", refs.map, Sampler::nearest_clamp);
}

CloudShadowMaps::CloudShadowMaps(gpu::Device& device, const Clouds& clouds, const CloudShadowParams& params)
    : device_(device), clouds_(clouds), params_(params) {
  const shared::CloudConstants& c = clouds.constants();
  const uint32_t tiles = std::clamp(params.resolution, 2 * kTile, shared::kShadowResolution) / kTile;
  const bool some = params.enabled && c.caster_count > 0 && !(c.uniform_density > 0.0f);
  double thickness_m = 1e9, slant = 0.0;
  if (some) {
    low_m_ = 1e9;
    high_m_ = -1e9;
    for (uint32_t k = 0; k < c.caster_count; ++k) {
      const Clouds::HeightRange& range = clouds.layer_ranges()[c.casters[k]];
      low_m_ = std::min(low_m_, range.low_m);
      high_m_ = std::max(high_m_, range.high_m);
      const shared::CloudLayerConstants& layer = c.layers[c.casters[k]];
      thickness_m = std::min(thickness_m, static_cast<double>(layer.thickness_m));
      slant += kSlant * static_cast<double>(layer.thickness_m / layer.cell_size_m) / c.caster_count;
      drift_mps_ = std::max(drift_mps_, static_cast<double>(length(layer.wind_mps) + layer.evolution_mps));
    }
    drift_mps_ += std::abs(clouds.params().weather.drift_east_mps);
    cascades_.resize(std::clamp(params.cascades, 1u, shared::kShadowCascades));
  }
  data_.cascades = static_cast<uint32_t>(cascades_.size());
  data_.resolution = tiles * kTile;
  data_.outside = mean_transmittance(clouds.params());
  data_.slant = static_cast<float>(slant);
  data_.hull_low_m = static_cast<float>(low_m_);
  data_.thickness_m = static_cast<float>(thickness_m);
  data_.hull_high_m = static_cast<float>(high_m_);
  for (Cascade& cascade : cascades_) {
    cascade.grid.tiles = tiles;
    cascade.slots.resize(size_t{tiles} * tiles);
  }
  const uint32_t side = some ? data_.resolution : 1;
  const auto layers = static_cast<uint32_t>(std::max<size_t>(cascades_.size(), 2));  // an array, even for one
  image_ = device.create_image(
      {.name = "clouds.shadow_map", .extent = {side, side}, .format = Format::rgba32u, .layers = layers});
  const std::vector<uint32_t> nothing(size_t{4} * side * side, 0);
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t k = 0; k < layers; ++k)
    uploads.push_back({.image = &image_, .bytes = std::as_bytes(std::span(nothing)), .layer = k});
  device.upload(uploads);
}

void CloudShadowMaps::set_march(const March& march) {
  march_ = march;
  pipelines_.clear();
  reset();
}

void CloudShadowMaps::reset() {
  for (Cascade& cascade : cascades_) {
    cascade.radius_m = 0.0;
    for (Slot& slot : cascade.slots) slot.rounds = 0;
  }
}

/// The light's frame: kept while what casts shadows moves them by less than a part of a texel.
void CloudShadowMaps::aim(const FrameInfo& frame) {
  const LightAxes axes = LightAxes::towards(glm::dvec3(frame.constants.key_dir));
  const double climb = std::max(dot(axes.light, glm::dvec3(frame.constants.camera_up)), 0.04);
  const double lever_m = std::clamp(high_m_ / climb, 1e3, 60e3);
  if (cascades_[0].radius_m > 0.0 && length(axes.light - axes_.light) * lever_m < 0.25 * cascades_[0].texel_m) return;
  axes_ = axes;
  reset();
}

/// Size and place of a cascade's window.
void CloudShadowMaps::fit(Cascade& cascade, const ShadowSlice& slice, const FrameInfo& frame, double& depth_m) const {
  const shared::FrameConstants& f = frame.constants;
  const double tangent = std::hypot(static_cast<double>(length(f.right)), static_cast<double>(length(f.up)));
  const SliceBall ball = ball_of_slice(slice.near_m, slice.far_m, std::min(std::atan(tangent), 1.5));
  const glm::dvec3 centre = frame.camera_ecef_m + ball.ahead_m * normalize(glm::dvec3(f.forward));
  depth_m = dot(centre, axes_.light);
  const uint32_t tiles = cascade.grid.tiles;
  const bool fits = cascade.radius_m >= ball.radius_m && cascade.radius_m <= kLargest * ball.radius_m &&
                    std::abs(depth_m - cascade.depth_zero_m) < cascade.radius_m;
  if (!fits) {
    cascade.radius_m = kMargin * ball.radius_m;
    // The ball, wherever it lies within a tile, and a rim of tiles for its neighbours.
    cascade.grid.tile_m = 2.0 * cascade.radius_m / (tiles - 4);
    cascade.texel_m = cascade.grid.tile_m / kTile;
    cascade.depth_zero_m = depth_m;
    for (Slot& slot : cascade.slots) slot.rounds = 0;
  }
  const auto first = [&](const glm::dvec3& axis) {
    return static_cast<int64_t>(std::floor(dot(centre, axis) / cascade.grid.tile_m)) - tiles / 2;
  };
  cascade.grid.first_x = first(axes_.x);
  cascade.grid.first_y = first(axes_.y);
}

/// Fits all cascades to the frame, and says which tiles might be marched: those that are missing or wrong first.
std::vector<CloudShadowMaps::Candidate> CloudShadowMaps::plan(const FrameInfo& frame) {
  const shared::FrameConstants& f = frame.constants;
  const double height_m = static_cast<double>(f.planet.camera_height_m);
  const double far_m = params_.far_m > 0.0 ? params_.far_m : automatic_shadow_range_m(height_m, high_m_);
  const std::vector<ShadowSlice> slices = shadow_slices(params_, height_m - high_m_, far_m);
  std::vector<Candidate> candidates;
  work_ = {};
  for (uint32_t k = 0; k < cascades_.size(); ++k) {
    Cascade& cascade = cascades_[k];
    double depth_m = 0.0;
    fit(cascade, slices[k], frame, depth_m);
    const uint32_t tiles = cascade.grid.tiles;
    const std::vector<uint8_t> seen = tiles_in_view(f, frame.camera_ecef_m, axes_, cascade.grid, slices[k].near_m,
                                                    slices[k].far_m, kLowestGround_m, high_m_);
    const std::vector<uint8_t> wanted = widened(seen, tiles);

    shared::ShadowCascade& to = data_.at[k];
    const glm::dvec3 corner = static_cast<double>(cascade.grid.first_x) * cascade.grid.tile_m * axes_.x +
                              static_cast<double>(cascade.grid.first_y) * cascade.grid.tile_m * axes_.y +
                              cascade.depth_zero_m * axes_.light;
    to.corner = glm::vec3(corner - frame.camera_ecef_m);
    to.texel_m = static_cast<float>(cascade.texel_m);
    const uint32_t first_x = place_of(cascade.grid.first_x, tiles), first_y = place_of(cascade.grid.first_y, tiles);
    to.first = glm::uvec2(first_x, first_y) * kTile;
    // Points in view are within twice the radius of the zero, to which depths beyond are cut.
    to.depth_unit_m = static_cast<float>(4.0 * cascade.radius_m / 65536.0);
    to.reach_m = static_cast<float>(slices[k].far_m);
    to.fade_m = static_cast<float>(slices[k].fade_m);
    to.high_m = static_cast<float>(2.0 * cascade.radius_m);
    to.low_m = -to.high_m;
    const double climb = std::max(
        dot(axes_.light,
            normalize(axes_.light * depth_m +
                      axes_.x * (static_cast<double>(cascade.grid.first_x) + 0.5 * tiles) * cascade.grid.tile_m +
                      axes_.y * (static_cast<double>(cascade.grid.first_y) + 0.5 * tiles) * cascade.grid.tile_m)),
        0.03);
    const double way_m = (high_m_ - low_m_) / climb;
    to.slabs = static_cast<uint32_t>(
        std::clamp(std::ceil(way_m / std::max(1.5 * cascade.texel_m, 50.0)), 8.0, double{shared::kShadowSlabs}));

    std::vector<uint8_t> present(wanted.size(), 0);
    for (uint32_t y = 0; y < tiles; ++y)
      for (uint32_t x = 0; x < tiles; ++x) {
        const size_t at = size_t{y} * tiles + x;
        const size_t slot_at = size_t{(y + first_y) % tiles} * tiles + (x + first_x) % tiles;
        Slot& slot = cascade.slots[slot_at];
        const int64_t grid_x = cascade.grid.first_x + x, grid_y = cascade.grid.first_y + y;
        const bool there = slot.rounds > 0 && slot.x == grid_x && slot.y == grid_y;
        const double age_s = std::abs(frame.time_s - slot.time_s);
        const double drift_m = age_s * drift_mps_;
        const bool wrong = !there || drift_m > kWrong_texels * cascade.texel_m;
        // What nobody could see waits.
        const bool aged = drift_m > kAged_texels * cascade.texel_m;
        if (wanted[at]) {
          ++work_.needed;
          const shared::ShadowTileWork tile{
              .cascade = k, .x = x, .y = y, .round = wrong || age_s > 0.0 ? 0 : slot.rounds};
          if (wrong || aged || (age_s <= 0.0 && slot.rounds < params_.rounds))
            candidates.push_back({tile, slot_at, wrong ? 1e30 : age_s, tile.round});
          if (!there) slot = {.x = grid_x, .y = grid_y};
          present[at] = 1;  // or will be: what is missing is marched in this frame
        } else {
          present[at] = there && !wrong ? 1 : 0;
        }
      }
    const std::vector<uint8_t> usable = surrounded(present, tiles);
    uint32_t* words = data_.usable + size_t{k} * shared::kShadowWords;
    std::fill(words, words + shared::kShadowWords, 0u);
    for (size_t i = 0; i < usable.size(); ++i)
      if (usable[i]) words[i / 32] |= 1u << (i % 32);
  }
  data_.axis_x = glm::vec3(axes_.x);
  data_.axis_y = glm::vec3(axes_.y);
  data_.light = glm::vec3(axes_.light);
  return candidates;
}

CloudShadowRefs CloudShadowMaps::add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density) {
  std::map<std::array<uint32_t, 2>, std::vector<shared::ShadowTileWork>> marches;  // by detail, merging
  if (!cascades_.empty()) {
    aim(frame);
    std::vector<Candidate> candidates = plan(frame);
    // All that is missing or wrong; of the rest a share, the oldest and least marched first.
    std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.age_s != b.age_s ? a.age_s > b.age_s : a.rounds < b.rounds;
    });
    const uint32_t share = (work_.needed + params_.slices - 1) / std::max(params_.slices, 1u);
    uint32_t others = 0;
    for (const Candidate& c : candidates) {
      if (c.age_s < 1e30 && ++others > share) break;
      marches[{detail_of(cascades_[c.tile.cascade]), c.rounds > 0 ? 1u : 0u}].push_back(c.tile);
      ++work_.marched;
      Slot& slot = cascades_[c.tile.cascade].slots[c.slot];
      slot.time_s = frame.time_s;
      slot.rounds = c.rounds + 1;
    }
  }
  data_buffer_ = graph.constants("clouds.shadow_data", data_);
  for (const auto& [kind, tiles] : marches) add_march(graph, frame, density, tiles, kind[0], kind[1] != 0);
  return {.data = data_buffer_, .map = graph.import(image_)};
}

/// Noises that a texel's size hides are left out, and their variance reckoned with.
uint32_t CloudShadowMaps::detail_of(const Cascade& cascade) const {
  if (march_.detail > 0) return march_.detail;
  return cascade.texel_m < kDetailHidden * std::abs(clouds_.params().noise.detail.period_m) ? 3 : 2;
}

void CloudShadowMaps::add_march(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density,
                                const std::vector<shared::ShadowTileWork>& tiles, uint32_t detail, bool merge) {
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = pipelines_[{phases, detail, merge ? 1u : 0u}];
  if (!pipeline) {
    std::vector<uint32_t> constants = clouds_.specialisation(phases);
    constants.resize(5);
    constants.push_back(detail);
    constants.push_back(merge ? 1u : 0u);
    pipeline = gpu::ComputePipeline(
        device_, {.name = "clouds.shadow", .spirv = shadow_map_march_comp, .constants = std::move(constants)});
  }
  auto pass = graph.pass(merge ? "clouds.shadow_resolve" : "clouds.shadow");
  pass.uniform("frame", frame.buffer)
      .uniform("cloud_shadow", data_buffer_)
      .read("tiles", graph.constants("clouds.shadow_tiles", tiles))
      .read_write("shadow_map", graph.import(image_))
      .effect();
  bind_density(pass, density);
  pass.record([this, &pipeline, count = static_cast<uint32_t>(tiles.size())](gpu::Commands& cmd) {
    cmd.bind(pipeline);
    for (uint32_t first = 0; first < count; first += kMostGroups)
      cmd.push(MarchPush{first, march_.step_scale, march_.footprint})
          .dispatch_threads(64 * std::min(kMostGroups, count - first));
  });
}

}  // namespace nepho
