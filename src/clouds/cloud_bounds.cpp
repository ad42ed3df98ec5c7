#include "clouds/cloud_bounds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "clouds/cloud_bounds.comp.h"
#include "clouds/cloud_bounds_runs.comp.h"
#include "geo/planet_view.h"
#include "geo/region_map.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::CloudBounds) == sizeof(shared::RegionMap) + 4 * 16 + 8);
static_assert(sizeof(shared::RegionMap) == 48);

struct BoundsPush {
  uint32_t level, flat_bounds;
};

/// Heights of all layers as few bands, lowest first; bands share the slices by the root of their thickness.
void set_bands(shared::CloudBounds& to, std::vector<Clouds::HeightRange> ranges, uint32_t slices) {
  std::sort(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) { return a.low_m < b.low_m; });
  std::vector<Clouds::HeightRange> bands;
  for (const Clouds::HeightRange& r : ranges) {
    if (!bands.empty() && r.low_m <= bands.back().high_m)
      bands.back().high_m = std::max(bands.back().high_m, r.high_m);
    else
      bands.push_back(r);
  }
  double roots = 0.0;
  for (const Clouds::HeightRange& b : bands) roots += std::sqrt(b.high_m - b.low_m);
  to.bands = static_cast<uint32_t>(bands.size());
  float first = 0.0f;
  for (size_t i = 0; i < bands.size(); ++i) {
    const auto k = static_cast<int>(i);
    const double share = std::sqrt(bands[i].high_m - bands[i].low_m) / roots;
    const auto spare = static_cast<float>(slices - 2 * bands.size());
    to.band_low_m[k] = static_cast<float>(bands[i].low_m);
    to.band_high_m[k] = static_cast<float>(bands[i].high_m);
    to.band_first[k] = first;
    to.band_slices[k] = 2.0f + std::floor(spare * static_cast<float>(share));
    first += to.band_slices[k];
  }
}

float most_extinction(const Clouds& clouds) {
  const shared::CloudConstants& c = clouds.constants();
  float sum = 0.0f;
  for (uint32_t l = 0; l < c.layer_count; ++l) {
    float densest = 0.0f;
    for (int i = 0; i <= 32; ++i)
      densest = std::max(densest, shared::density_profile(c.layers[l].profile, static_cast<float>(i) / 32.0f));
    sum += c.layers[l].extinction_per_m * (c.uniform_density > 0.0f ? c.uniform_density : 2.0f * densest);
  }
  return sum;
}

}  // namespace

CloudBoundsMap::CloudBoundsMap(gpu::Device& device, const Clouds& clouds)
    : device_(device),
      clouds_(clouds),
      bounds_(2),
      runs_(device, {.name = "clouds.bounds_runs", .spirv = cloud_bounds_runs_comp}) {}

void CloudBoundsMap::add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density,
                         const shared::RegionMap& map, Detail detail) {
  data_ = cloud_bands(clouds_);
  data_.map = map;
  const Extent3D extent{shared::kBoundsTexels, shared::kBoundsTexels, shared::kBoundsSlices * map.levels};
  if (!image_ || !(image_.desc().extent == extent))
    image_ = device_.create_image({.name = "clouds.bounds", .extent = extent, .format = Format::r32f});
  if (data_.bands == 0) return;  // nothing is ever read
  const BufferRef data = graph.constants("clouds.bounds_data", data_);
  const ImageRef image = graph.import(image_);
  const uint32_t phases = clouds_.phases_at(frame.time_s);
  gpu::ComputePipeline& pipeline = bounds_[phases - 1];
  if (!pipeline)
    pipeline = gpu::ComputePipeline(
        device_, {.name = "clouds.bounds", .spirv = cloud_bounds_comp, .constants = clouds_.specialisation(phases)});
  auto pass = graph.pass("clouds.bounds");
  pass.uniform("frame", frame.buffer).uniform("bounds", data).read_write("out_bounds", image).effect();
  bind_density(pass, density);
  const uint32_t flat = detail == Detail::layers ? 1u : 0u;
  pass.record([&pipeline, flat, levels = map.levels](gpu::Commands& cmd) {
    cmd.bind(pipeline);
    for (uint32_t level = 0; level < levels; ++level) {
      cmd.push(BoundsPush{level, flat}).dispatch_threads(shared::kBoundsTexels, shared::kBoundsTexels);
      cmd.barrier();
    }
  });
  auto runs = graph.pass("clouds.bounds_runs");
  runs.uniform("bounds", data).read_write("out_bounds", image).effect();
  runs.record([this, levels = map.levels](gpu::Commands& cmd) {
    cmd.bind(runs_).dispatch_threads(shared::kBoundsTexels, shared::kBoundsTexels, levels);
  });
}

void CloudBoundsMap::set_even(double low_m, double high_m, double most_per_m) {
  data_ = shared::CloudBounds{};
  data_.map.half_m = 1.0f;
  data_.bands = 1;
  data_.band_low_m[0] = static_cast<float>(low_m);
  data_.band_high_m[0] = static_cast<float>(high_m);
  data_.band_slices[0] = 1.0f;
  data_.most_per_m = static_cast<float>(most_per_m);
  const Extent3D none{1, 1, 2};  // bound, never read
  if (image_ && image_.desc().extent == none) return;
  image_ = device_.create_image({.name = "clouds.bounds", .extent = none, .format = Format::r32f});
  const float zeros[2] = {};
  const gpu::ImageUpload upload{.image = &image_, .bytes = std::as_bytes(std::span(zeros))};
  device_.upload({&upload, 1});
}

shared::CloudBounds cloud_bands(const Clouds& clouds, uint32_t slices) {
  shared::CloudBounds bounds{};
  bounds.most_per_m = most_extinction(clouds);
  set_bands(bounds, clouds.layer_ranges(), slices);
  return bounds;
}

shared::RegionMap cloud_region(const shared::FrameConstants& frame, const glm::dvec3& camera_ecef_m, double top_m) {
  constexpr double kHalf_m = 10e3, kLooksDownFrom_m = 15e3;
  const double a = static_cast<double>(frame.planet.a_m);
  const double height_m = std::max(static_cast<double>(frame.planet.camera_height_m), 0.0);
  // How far away on the ground clouds show above the horizon.
  const auto dip = [&](double h_m) { return std::acos(a / (a + h_m)); };
  double reach_m = a * (dip(height_m) + dip(std::max(top_m, 100.0))) + 30e3;
  glm::dvec3 centre = camera_ecef_m;
  if (height_m > kLooksDownFrom_m) {
    const glm::vec3 forward = normalize(frame.forward);
    glm::vec2 t;
    if (shared::intersect_shell(frame.planet, forward, 0.0f, t) && t.x > 0.0f) {
      const glm::dvec3 hit = camera_ecef_m + glm::dvec3(forward) * static_cast<double>(t.x);
      reach_m += a * std::acos(std::clamp(dot(normalize(hit), normalize(centre)), -1.0, 1.0));
      centre = hit;
    }
  }
  // Lambert's plane: the arc's chord is shorter than the arc.
  uint32_t levels = 1;
  while (kHalf_m * std::exp2(levels - 1) < std::min(reach_m, 1.9 * a) && levels < 12) ++levels;
  return make_region_map(centre, kHalf_m, levels, Ellipsoid::wgs84());
}

}  // namespace nepho
