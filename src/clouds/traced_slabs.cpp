#include "clouds/traced_slabs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/progress.h"
#include "clouds/path_mean.comp.h"
#include "clouds/path_mean_shared.h"
#include "clouds/path_tracer.h"
#include "common/random.h"
#include "geo/frames.h"
#include "geo/planet_view.h"
#include "geo/region_map.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::PathMean) == 20);

constexpr double kGap_m = 1.0;        ///< of rays' origins from the layer
constexpr double kBoundsGap_m = 0.5;  ///< of the majorant's band, for the heights' rounding
constexpr uint32_t kPilot = 256;      ///< paths a ray that say how many it wants
constexpr double kUnseen = 0.1;       ///< 1/sr, of one path
constexpr int kRounds = 24;           ///< at most
constexpr double kDefaultNoise = 0.02;
/// Of fluxes: relative error, and the absolute one that does, per noise.
constexpr double kFluxNoise = 0.15, kLeastFlux = 0.05;
/// Of radiances: the absolute error that does, per noise and irradiance of a horizontal plane, 1/sr.
constexpr double kLeastRadiance = 0.005;
/// Moves of a row's paths along their flights, at the default noise. Software devices make a million a second.
constexpr double kMovesOfCpu = 3.5e6, kMovesOfGpu = 350e6;
constexpr uint32_t kDirectSamples = 0x80000000u;  ///< first of those of the direct transmittance

/// As MarchedSlabs: at 0N 0E the vertical is ECEF +X; sunlight travels eastwards.
constexpr dvec3 kUp{1.0, 0.0, 0.0}, kEast{0.0, 1.0, 0.0}, kNorth{0.0, 0.0, 1.0};
constexpr double kMiddle_m = 0.5 * (kSlabBase_m + kSlabTop_m);

dvec3 camera_ecef() { return ecef_from_geodetic(Geodetic::from_degrees(0.0, 0.0, kMiddle_m)); }

/// From just above the layer, or just below it.
shared::PathRay ray_from(bool above, const dvec3& dir) {
  const double height_m = above ? kSlabTop_m + kGap_m : kSlabBase_m - kGap_m;
  return {.origin = vec3((height_m - kMiddle_m) * kUp), .spread = 0.0f, .dir = vec3(dir), .pad = 0.0f};
}

dvec3 sun_dir(const Slab& slab) { return slab.mu0 * kUp - std::sqrt(std::max(1.0 - slab.mu0 * slab.mu0, 0.0)) * kEast; }

dvec3 looking_along(const SlabDirection& d) {
  const double phi = rad_from_deg(d.phi_deg), sine = std::sqrt(std::max(1.0 - d.mu * d.mu, 0.0));
  return -(sine * (std::cos(phi) * kEast + std::sin(phi) * kNorth) + (d.up ? d.mu : -d.mu) * kUp);
}

/// A mean over paths.
struct Estimate {
  double paths = 0.0, mean = 0.0, squares = 0.0;
  void add(double more, const shared::MeanOf& m) {
    if (more == 0.0) return;
    const double all = paths + more, share = more / all, apart = static_cast<double>(m.mean) - mean;
    mean += apart * share;
    squares += static_cast<double>(m.squares) + apart * apart * paths * share;
    paths = all;
  }
  double variance() const { return paths > 1.0 ? squares / (paths - 1.0) : 0.0; }  ///< of one path
  double error() const { return paths > 0.0 ? std::sqrt(variance() / paths) : 0.0; }
};

struct Ray {
  shared::PathRay ray{};
  std::vector<size_t> directions = {};  ///< that its light stands for; none: a flux, by the paths that escape
  double noise = 0.0, least = 0.0;      ///< relative and absolute error wanted
  Estimate estimate = {}, pilot = {};
  uint32_t next_sample = 0;

  void add(const shared::PathMean& m, Estimate& to) const {
    to.add(m.paths, directions.empty() ? m.escaped : m.sunlit);
  }
  /// Paths beyond those that there are.
  double missing() const {
    const Estimate& known = estimate.paths < kPilot ? pilot : estimate;
    const double error = std::max(noise * std::abs(known.mean), least);
    // Of light that few paths find, what was seen says too little: as if one more had found as much as light is.
    const double unseen = kUnseen * kUnseen / std::max(known.paths, 1.0);
    const double wanted = std::ceil(std::max((known.variance() + unseen) / (error * error), double{kPilot}));
    // A few are not worth a round.
    return wanted < 1.1 * estimate.paths ? 0.0 : wanted - estimate.paths;
  }
  double importance() const { return directions.empty() ? 40.0 : 1.0; }
};

/// Paths that enter the layer as sunlight does and leave it on the other side or on the same one, as light does, are
/// the fluxes. Downwards the black ground takes them: so the one for the transmittance enters from below, which is the
/// same.
std::vector<Ray> rays_for(const Slab& slab, double noise) {
  std::vector<Ray> rays;
  for (const bool above : {true, false})
    rays.push_back({.ray = ray_from(above, above ? -sun_dir(slab) : sun_dir(slab)),
                    .noise = kFluxNoise * noise,
                    .least = kLeastFlux * noise});
  const auto& all = slab_directions();
  for (size_t i = 0; i < all.size(); ++i) {
    const bool even = (slab.g == 0.0 && slab.droplet_diameter_um == 0.0) || slab.mu0 == 1.0 || all[i].mu == 1.0;
    if (even && all[i].phi_deg > 0.0)
      rays.back().directions.push_back(i);
    else
      rays.push_back({.ray = ray_from(all[i].up, looking_along(all[i])),
                      .directions = {i},
                      .noise = noise,
                      .least = kLeastRadiance * noise * slab.mu0});
  }
  return rays;
}

/// Shares out `budget` paths. Of a third all get as many; the rest goes to those who want least first: what thick
/// layers let through would want a software device for hours, and take from all others.
std::vector<uint32_t> shared_out(const std::vector<Ray>& rays, double budget) {
  std::vector<double> missing, given;
  std::vector<size_t> order(rays.size());
  double parts = 0.0;
  for (const Ray& r : rays) {
    missing.push_back(r.missing());
    parts += r.importance();
  }
  for (size_t i = 0; i < rays.size(); ++i) {
    given.push_back(std::min(missing[i], budget / 3.0 * rays[i].importance() / parts));
    order[i] = i;
  }
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return missing[a] / rays[a].importance() < missing[b] / rays[b].importance(); });
  double left = budget;
  for (const double paths : given) left -= paths;
  for (const size_t i : order) {
    const double more = std::min(missing[i] - given[i], left);
    given[i] += more;
    left -= more;
  }
  std::vector<uint32_t> samples;
  for (const double paths : given) samples.push_back(static_cast<uint32_t>(std::max(paths, 0.0)));
  return samples;
}

uint32_t seed_of(const Slab& slab, uint32_t seed) {
  const auto word = [](double v) { return std::bit_cast<uint32_t>(static_cast<float>(v)); };
  return shared::hash4(shared::hash4({word(slab.tau), word(slab.single_scattering_albedo), word(slab.g), seed}) +
                       glm::uvec4(word(slab.mu0)))
      .x;
}

}  // namespace

struct TracedSlabs::Parts {
  Parts(gpu::Device& gpu_device, double wanted_noise, uint32_t first_seed)
      : device(gpu_device),
        noise(wanted_noise > 0.0 ? wanted_noise : kDefaultNoise),
        seed(first_seed),
        clouds(device, slab_clouds({})),
        bounds(device, clouds),
        tracer(device, clouds, PathTracer::Mode::table),
        mean(device, {.name = "paths.mean", .spirv = path_mean_comp}),
        ground(make_region_map(camera_ecef(), 10e3, 1)),
        executor(device) {}

  std::vector<shared::PathMean> run(const Slab& slab, std::span<const shared::PathRay> rays,
                                    std::span<const uint32_t> samples, std::span<const uint32_t> first_samples);
  void trace_rays(const Slab& slab, std::vector<Ray>& rays);
  Estimate direct(const Slab& slab);

  gpu::Device& device;
  double noise;
  uint32_t seed;
  Clouds clouds;
  CloudBoundsMap bounds;
  PathTracer tracer;
  gpu::ComputePipeline mean;
  shared::RegionMap ground;
  gpu::GraphExecutor executor;
};

std::vector<shared::PathMean> TracedSlabs::Parts::run(const Slab& slab, std::span<const shared::PathRay> rays,
                                                      std::span<const uint32_t> samples,
                                                      std::span<const uint32_t> first_samples) {
  FrameInfo frame;
  frame.extent = {1, 1};
  frame.camera_ecef_m = camera_ecef();
  shared::FrameConstants& c = frame.constants;
  c.planet = make_planet_view(frame.camera_ecef_m);
  c.forward = vec3(kNorth);
  c.right = vec3(kEast);
  c.up = c.camera_up = vec3(kUp);
  c.light_count = 1;
  c.size = {1, 1};
  c.near_m = 0.1f;
  c.sun_dir = c.key_dir = vec3(sun_dir(slab));
  shared::CloudConstants constants = slab_constants(clouds, slab);
  constants.anchor = clouds.anchor(frame.camera_ecef_m, frame.time_s);
  bounds.set_even(kSlabBase_m - kBoundsGap_m, kSlabTop_m + kBoundsGap_m,
                  static_cast<double>(constants.layers[0].extinction_per_m));
  const std::vector<shared::PathRay> ray_list(rays.begin(), rays.end());
  const auto inputs = [&](FrameGraph& graph, const FrameInfo&) {
    PathTracer::Inputs in;
    in.density = {.constants = graph.constants("clouds.constants", constants),
                  .weather = clouds.weather().import_into(graph),
                  .noise = clouds.noise().import_into(graph)};
    in.bounds = &bounds;
    in.ground = ground;
    in.rays = graph.constants("slab.rays", ray_list);
    return in;
  };
  shared::PathPush push{};
  push.seed = seed_of(slab, seed);
  push.width = 1;
  push.subpixels = 1;
  tracer.run(executor, frame, inputs, samples, first_samples, push);

  FrameGraph graph;
  const BufferRef means = graph.create_buffer("paths.means", rays.size() * sizeof(shared::PathMean));
  graph.keep(means);
  graph.pass("paths.mean")
      .read("results", graph.import(tracer.results()))
      .read("plan", graph.import(tracer.plan()))
      .write("means", means)
      .record([this, count = static_cast<uint32_t>(rays.size())](gpu::Commands& cmd) {
        cmd.bind(mean).dispatch_threads(64 * count);
      });
  executor.run(graph);
  return executor.read<shared::PathMean>(means);
}

/// A pilot says how many paths each ray wants; its own do not count, so that no ray stops because it was lucky. Later
/// rounds mend what the pilot thought too even.
void TracedSlabs::Parts::trace_rays(const Slab& slab, std::vector<Ray>& rays) {
  std::vector<shared::PathRay> looks;
  for (const Ray& r : rays) looks.push_back(r.ray);
  std::vector<uint32_t> samples(rays.size(), kPilot), first(rays.size(), 0);
  const std::vector<shared::PathMean> pilot = run(slab, looks, samples, first);
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i].add(pilot[i], rays[i].pilot);
    rays[i].next_sample = kPilot;
  }
  const double moves_a_path = std::max<double>(tracer.counts().moves, 1.0) / std::max(tracer.counts().paths, 1u);
  const double finer = kDefaultNoise / noise;
  const double all = std::max(finer * finer * (device.info().is_software ? kMovesOfCpu : kMovesOfGpu) / moves_a_path,
                              2.0 * kPilot * static_cast<double>(rays.size()));
  double left = all;
  for (int round = 0; round < kRounds; ++round) {
    samples = shared_out(rays, std::min(left, static_cast<double>(tracer.most_paths())));
    double total = 0.0;
    for (size_t i = 0; i < rays.size(); ++i) {
      first[i] = rays[i].next_sample;
      rays[i].next_sample += samples[i];
      total += samples[i];
    }
    if (total < 0.02 * all && round > 0) break;
    const std::vector<shared::PathMean> means = run(slab, looks, samples, first);
    for (size_t i = 0; i < rays.size(); ++i) rays[i].add(means[i], rays[i].estimate);
    left -= total;
  }
}

/// Paths towards the sun through a layer that only absorbs: each escapes or does not.
Estimate TracedSlabs::Parts::direct(const Slab& slab) {
  Slab black = slab;
  black.single_scattering_albedo = 0.0;
  const shared::PathRay ray = ray_from(false, sun_dir(slab));
  Estimate all;
  uint32_t samples = 4096, first = kDirectSamples;
  for (int round = 0; round < 2; ++round) {
    all.add(samples, run(black, {&ray, 1}, {&samples, 1}, {&first, 1}).front().escaped);
    const double wanted = std::min(all.variance() / std::pow(kLeastFlux * noise, 2.0), 1.0 * tracer.most_paths());
    if (wanted <= all.paths) break;
    first += samples;
    samples = static_cast<uint32_t>(std::ceil(wanted - all.paths));
  }
  return all;
}

TracedSlabs::TracedSlabs(gpu::Device& device, double noise, uint32_t seed)
    : parts_(std::make_unique<Parts>(device, noise, seed)) {}
TracedSlabs::~TracedSlabs() = default;

TracedSlab TracedSlabs::trace(const Slab& slab) {
  std::vector<Ray> rays = rays_for(slab, parts_->noise);
  parts_->trace_rays(slab, rays);
  const Estimate direct = parts_->direct(slab);
  TracedSlab out;
  const Estimate &up = rays[0].estimate, &down = rays[1].estimate;
  out.light.reflectance = up.mean;
  out.error.reflectance = up.error();
  out.light.transmittance_direct = direct.mean;
  out.error.transmittance_direct = direct.error();
  out.light.transmittance_diffuse = std::max(down.mean - direct.mean, 0.0);
  out.error.transmittance_diffuse = std::hypot(down.error(), direct.error());
  out.paths = static_cast<uint64_t>(direct.paths);
  for (const Ray& r : rays) {
    out.paths += r.next_sample;
    for (const size_t i : r.directions) {
      out.light.radiance[i] = r.estimate.mean;
      out.error.radiance[i] = r.estimate.error();
    }
  }
  return out;
}

std::vector<SlabLight> TracedSlabs::solve(std::span<const Slab> slabs) {
  Progress progress("slabs");
  std::vector<SlabLight> lights;
  for (const Slab& slab : slabs) {
    lights.push_back(trace(slab).light);
    progress.update(static_cast<double>(lights.size()) / static_cast<double>(slabs.size()));
  }
  return lights;
}

}  // namespace nepho
