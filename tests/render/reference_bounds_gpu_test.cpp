// Majorants of the path tracer, and what it tracks through them, against the density itself.
#include <cstring>
#include <glm/geometric.hpp>
#include <random>

#include "clouds/cloud_anchor.h"
#include "clouds/cloud_probe.h"
#include "clouds/path_tracer.h"
#include "geo/frames.h"
#include "geo/region_map.h"
#include "render/frame_setup.h"
#include "render/reference_scene.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr double kTime_s = 20.5 * kWindow_s;

/// Clouds about a place, with majorants of both kinds.
struct Sky {
  gpu::Device& device;
  gpu::GraphExecutor executor;
  Clouds clouds;
  CloudBoundsMap fine, coarse;
  Geodetic camera;
  FrameInfo frame;

  Sky(gpu::Device& gpu_device, const CloudParams& params, double height_m)
      : device(gpu_device),
        executor(device),
        clouds(device, params),
        fine(device, clouds),
        coarse(device, clouds),
        camera(Geodetic::from_degrees(35.5, 138.75)) {
    camera.height_m = height_m;
    CameraParams looks;
    looks.lat_deg = 35.5;
    looks.lon_deg = 138.75;
    looks.height_m = height_m;
    const CameraPose pose = resolve_camera(looks, [](double, double) { return 0.0; });
    FrameGraph graph;
    frame.extent = {1, 1};
    frame.camera_ecef_m = pose.ecef_m;
    frame.time_s = kTime_s;
    frame.constants = make_frame_constants(pose, frame.extent, FrameLight{}, kTime_s, 0, 0, glm::vec2(0.0f));
    frame.buffer = graph.constants("frame", frame.constants);
    const CloudDensityRefs density = import_cloud_density(graph, frame, clouds);
    const shared::RegionMap map = cloud_region(frame.constants, frame.camera_ecef_m, 20e3);
    fine.add(graph, frame, density, map);
    coarse.add(graph, frame, density, map, CloudBoundsMap::Detail::layers);
    executor.run(graph);
  }
};

/// Majorants as the tracer reads them.
class Majorants {
 public:
  Majorants(gpu::Device& device, const CloudBoundsMap& from) : data_(from.data()) {
    const std::vector<std::byte> bytes = device.download(from.image());
    texels_.resize(bytes.size() / sizeof(float));
    std::memcpy(texels_.data(), bytes.data(), bytes.size());
  }
  float at(const dvec3& ecef_m, double height_m) const {
    const auto h = static_cast<float>(height_m);
    int slice = -1;
    for (int b = 0; b < static_cast<int>(data_.bands); ++b)
      if (h >= data_.band_low_m[b] && h < data_.band_high_m[b]) {
        const float step_m = (data_.band_high_m[b] - data_.band_low_m[b]) / data_.band_slices[b];
        slice = static_cast<int>(data_.band_first[b] +
                                 std::min(std::floor((h - data_.band_low_m[b]) / step_m), data_.band_slices[b] - 1.0f));
      }
    if (slice < 0) return 0.0f;
    const Ellipsoid& e = Ellipsoid::wgs84();
    const glm::vec2 xy =
        shared::region_xy(data_.map, glm::vec3(glm::normalize(dvec3(ecef_m.x, ecef_m.y, ecef_m.z * e.a_over_b()))));
    const uint32_t level = shared::region_level(data_.map, xy);
    REQUIRE(level < data_.map.levels);
    const float wide = texel(xy, std::min(level + 2u, data_.map.levels - 1u), slice);
    return wide <= 0.0f ? 0.0f : std::max(texel(xy, level, slice), 0.0f);
  }
  /// Share of the texels of the finest level, in slices of bands, that hold nothing.
  double empty_share() const {
    size_t used = 0;
    for (int b = 0; b < static_cast<int>(data_.bands); ++b) used += static_cast<size_t>(data_.band_slices[b]);
    const size_t all = used * shared::kBoundsTexels * shared::kBoundsTexels;
    size_t empty = 0;
    for (size_t i = 0; i < all; ++i) empty += texels_[i] <= 0.0f ? 1 : 0;
    return static_cast<double>(empty) / static_cast<double>(all);
  }

 private:
  float texel(glm::vec2 xy, uint32_t level, int slice) const {
    const auto side = static_cast<int>(shared::kBoundsTexels);
    const float per_m = 0.5f * static_cast<float>(side) / shared::region_half_m(data_.map, level);
    const auto cell = [&](float v) {
      return std::clamp(static_cast<int>(std::floor(v * per_m)) + side / 2, 0, side - 1);
    };
    const auto z = static_cast<size_t>(static_cast<int>(level * shared::kBoundsSlices) + slice);
    return texels_[(z * static_cast<size_t>(side) + static_cast<size_t>(cell(xy.y))) * static_cast<size_t>(side) +
                   static_cast<size_t>(cell(xy.x))];
  }
  shared::CloudBounds data_;
  std::vector<float> texels_;
};

/// Paths along rays; how many of each met no cloud.
struct Passed {
  std::vector<double> share;
  shared::PathCounts counts{};
};

Passed trace(Sky& sky, PathTracer& tracer, const CloudBoundsMap& bounds, const std::vector<dvec3>& dirs,
             uint32_t paths) {
  std::vector<shared::PathRay> rays;
  for (const dvec3& d : dirs)
    rays.push_back({.origin = glm::vec3(0.0f), .spread = 0.0f, .dir = glm::vec3(d), .pad = 0.0f});
  const shared::RegionMap ground = make_region_map(sky.frame.camera_ecef_m, 10e3, 1);
  const auto inputs = [&](FrameGraph& graph, const FrameInfo& frame) {
    PathTracer::Inputs in;
    in.density = import_cloud_density(graph, frame, sky.clouds);
    in.bounds = &bounds;
    in.ground = ground;
    in.rays = graph.constants("test.rays", rays);
    return in;
  };
  shared::PathPush push{};
  push.seed = 77;
  push.width = 1;
  push.subpixels = 1;
  const std::vector<uint32_t> samples(rays.size(), paths), first(rays.size(), 0);
  tracer.run(sky.executor, sky.frame, inputs, samples, first, push);
  const std::vector<std::byte> bytes = sky.device.download(tracer.results());
  Passed passed{.share = std::vector<double>(rays.size(), 0.0), .counts = tracer.counts()};
  for (size_t i = 0; i < rays.size() * paths; ++i) {
    shared::PathResult r;
    std::memcpy(static_cast<void*>(&r), bytes.data() + i * sizeof(r), sizeof(r));
    passed.share[i / paths] += static_cast<double>(r.weight.x) / paths;  // 0: it did not get out
  }
  return passed;
}

/// Optical depth from the camera along a direction up to a distance, by the midpoints of small steps.
std::vector<double> march(Sky& sky, CloudProbe& probe, const std::vector<dvec3>& dirs, double from_m, double to_m,
                          double step_m) {
  const auto steps = static_cast<size_t>((to_m - from_m) / step_m);
  std::vector<CloudProbe::Case> cases;
  for (const dvec3& d : dirs)
    for (size_t i = 0; i < steps; ++i)
      cases.push_back({.point = geodetic_from_ecef(sky.frame.camera_ecef_m +
                                                   d * (from_m + (static_cast<double>(i) + 0.5) * step_m)),
                       .camera = sky.camera,
                       .time_s = kTime_s,
                       .footprint_m = 0.0});
  const std::vector<CloudProbe::Density> density = probe.density(cases);
  std::vector<double> tau(dirs.size(), 0.0);
  for (size_t i = 0; i < density.size(); ++i)
    tau[i / steps] += static_cast<double>(density[i].extinction_per_m) * step_m;
  return tau;
}

}  // namespace

TEST_CASE(
    "gpu: what passes the clouds along a ray is what a march in small steps says; density within its majorants saves "
    "reads") {
  GpuFixture f;
  CloudParams params = half_sky("cumulus", 0.4);
  params.scattering_per_m = 0.0;  // a path ends where it meets the first cloud
  params.absorption_per_m = 0.01;
  Sky sky(f.device, params, 300.0);
  CloudProbe probe(f.device, sky.clouds);
  PathTracer tracer(f.device, sky.clouds, PathTracer::Mode::table);
  const dmat3 enu = make_ecef_from_enu_rotation(sky.camera);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<dvec3> candidates, dirs;
  for (int i = 0; i < 80; ++i) {
    const double up = 0.5 + 0.5 * unit(random), turn = 6.2831853 * unit(random), flat = std::sqrt(1.0 - up * up);
    // As the tracer gets it.
    candidates.push_back(dvec3(glm::vec3(enu * dvec3(flat * std::cos(turn), flat * std::sin(turn), up))));
  }
  const double top_m = 1.05 * (sky.clouds.layer_ranges().front().high_m - 300.0) / 0.5;
  const std::vector<double> rough = march(sky, probe, candidates, 0.0, top_m, 20.0);
  for (size_t i = 0; i < rough.size() && dirs.size() < 10; ++i)
    if (rough[i] > 0.3 && rough[i] < 3.0) dirs.push_back(candidates[i]);
  REQUIRE(dirs.size() >= 6);
  const std::vector<double> tau = march(sky, probe, dirs, 0.0, top_m, full_size() ? 0.5 : 1.0);
  const uint32_t paths = full_size() ? 100000 : 10000;
  const Passed by_density = trace(sky, tracer, sky.fine, dirs, paths),
               by_layers = trace(sky, tracer, sky.coarse, dirs, paths);
  for (const auto* passed : {&by_density, &by_layers}) {
    double squares = 0.0;
    for (size_t i = 0; i < dirs.size(); ++i) {
      const double expected = std::exp(-tau[i]), error = std::sqrt(expected * (1.0 - expected) / paths);
      const double z = (passed->share[i] - expected) / error;
      CAPTURE(tau[i]);
      CHECK(std::abs(z) <= 4.0);
      squares += z * z;
    }
    // Chi-square: mean n, variance 2 n.
    const auto n = static_cast<double>(dirs.size());
    MESSAGE(n, " rays of optical depth 0.3 to 3: chi-square ", squares);
    CHECK(squares <= n + 3.0 * std::sqrt(2.0 * n));
    CHECK(passed->counts.overruns == 0);
  }
  MESSAGE("density reads a path: ", static_cast<double>(by_density.counts.density_reads) / by_density.counts.paths,
          ", by layers alone ", static_cast<double>(by_layers.counts.density_reads) / by_layers.counts.paths,
          "; moves ", static_cast<double>(by_density.counts.moves) / by_density.counts.paths, " and ",
          static_cast<double>(by_layers.counts.moves) / by_layers.counts.paths);
  CHECK(by_density.counts.density_reads < by_layers.counts.density_reads);
}

TEST_CASE("gpu: majorants hold, and hide no cloud where they are 0") {
  GpuFixture f;
  std::vector<std::pair<std::string, CloudParams>> skies = {{"cumulus", half_sky("cumulus")},
                                                            {"cirrus", half_sky("cirrus")}};
  if (full_size()) {
    skies.emplace_back("cumulonimbus", half_sky("cumulonimbus"));
    CloudParams broken = cloud_sky("broken").value();
    for (CloudLayer& layer : broken.layers) layer.base_reference = "ellipsoid";
    skies.emplace_back("broken", broken);
  }
  for (const auto& [name, params] : skies) {
    CAPTURE(name);
    Sky sky(f.device, params, 300.0);
    CloudProbe probe(f.device, sky.clouds);
    const Majorants majorants(f.device, sky.fine);
    const dmat4 ecef_from_enu = make_ecef_from_enu(sky.camera);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<CloudProbe::Case> cases;
    for (const Clouds::HeightRange& range : sky.clouds.layer_ranges())
      for (int i = 0; i < 50000; ++i) {
        const dvec3 p(ecef_from_enu * glm::dvec4(40e3 * unit(random) - 20e3, 40e3 * unit(random) - 20e3, 0.0, 1.0));
        Geodetic point = geodetic_from_ecef(p);
        point.height_m = range.low_m + (range.high_m - range.low_m) * unit(random);
        cases.push_back({.point = point, .camera = sky.camera, .time_s = kTime_s, .footprint_m = 0.0});
      }
    const std::vector<CloudProbe::Density> density = probe.density(cases);
    size_t above = 0, hidden = 0, cloud = 0;
    double sum = 0.0, hidden_sum = 0.0;
    for (size_t i = 0; i < cases.size(); ++i) {
      const float most = majorants.at(ecef_from_geodetic(cases[i].point), cases[i].point.height_m);
      const float sigma = density[i].extinction_per_m;
      cloud += sigma > 0.0f ? 1 : 0;
      hidden += sigma > 0.0f && most <= 0.0f ? 1 : 0;
      above += sigma > 1.001f * most ? 1 : 0;
      sum += static_cast<double>(sigma);
      if (most <= 0.0f) hidden_sum += static_cast<double>(sigma);
    }
    MESSAGE(name, ": ", cloud, " of ", cases.size(), " points in cloud, ", above, " above their majorant, ", hidden,
            " where that is 0, with ", hidden_sum / sum, " of the extinction; empty share of the finest level ",
            majorants.empty_share());
    CHECK(cloud > cases.size() / 100);
    CHECK(static_cast<double>(above) < 1e-4 * static_cast<double>(cases.size()));
    CHECK(hidden_sum < 3e-4 * sum);
    CHECK(majorants.empty_share() > 0.05);
  }
}
