#include "clouds/slab_probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "base/progress.h"
#include "clouds/cloud_march_pass.h"
#include "clouds/droplet_phase.h"
#include "geo/frames.h"
#include "geo/planet_view.h"
#include "gpu/graph_executor.h"

namespace nepho {
namespace {

constexpr double kCameraGap_m = 20.0;     // of the cameras above and below
constexpr Extent2D kDirectionSize{8, 4};  // of a direction's frame: the march's jitter needs some pixels to average out
constexpr double kDirectionHalf_rad = 1e-3;
constexpr uint32_t kSpectralGroups = 1;  // of the lighting, which is not run

/// At 0N 0E, where the vertical is ECEF +X. Sunlight travels eastwards.
constexpr dvec3 kUp{1.0, 0.0, 0.0}, kEast{0.0, 1.0, 0.0}, kNorth{0.0, 0.0, 1.0};

/// Directions of travel v = forward + x right + y up, x and y -1..1. Cameras look the other way.
struct Window {
  dvec3 forward, right, up;
  Extent2D size;
};

Window window_of(const SlabDirection& d) {
  const double phi = rad_from_deg(d.phi_deg), sine = std::sqrt(std::max(1.0 - d.mu * d.mu, 0.0));
  const dvec3 flat = std::cos(phi) * kEast + std::sin(phi) * kNorth,
              aside = -std::sin(phi) * kEast + std::cos(phi) * kNorth;
  const double z = d.up ? d.mu : -d.mu;
  return {sine * flat + z * kUp, kDirectionHalf_rad * aside, kDirectionHalf_rad * (sine * kUp - z * flat),
          kDirectionSize};
}

/// The northern half of a hemisphere of travel around `axis` (up or down), which mirrors the southern, as parts of the
/// faces of a cube.
std::vector<Window> hemisphere(const dvec3& axis, uint32_t px) {
  const uint32_t half = px / 2;
  return {{axis + 0.5 * kNorth, kEast, 0.5 * kNorth, {px, half}},
          {kNorth + 0.5 * axis, kEast, 0.5 * axis, {px, half}},
          {kEast + 0.5 * axis + 0.5 * kNorth, 0.5 * kNorth, 0.5 * axis, {half, half}},
          {-kEast + 0.5 * axis + 0.5 * kNorth, 0.5 * kNorth, 0.5 * axis, {half, half}}};
}

/// A camera and where it stands; the sun is filled in by row.
struct View {
  shared::FrameConstants constants{};
  gpu::Image depth_m;
  bool above = true;
};

dvec3 camera_ecef(bool above) {
  return ecef_from_geodetic(
      Geodetic::from_degrees(0.0, 0.0, above ? kSlabTop_m + kCameraGap_m : kSlabBase_m - kCameraGap_m));
}

View view_of(gpu::Device& device, const Window& window, bool above) {
  View view;
  view.above = above;
  shared::FrameConstants& c = view.constants;
  c.planet = make_planet_view(camera_ecef(above));
  c.forward = -vec3(window.forward);
  c.right = -vec3(window.right);
  c.up = -vec3(window.up);
  c.camera_up = vec3(kUp);
  c.pixel_angle_rad =
      static_cast<float>(2.0 * glm::length(window.up) / window.size.height / glm::length(window.forward));
  c.light_count = 1;
  c.size = {window.size.width, window.size.height};
  c.near_m = 0.1f;
  // The ground ends rays, as the terrain does in pictures.
  std::vector<float> depth_m(size_t{window.size.width} * window.size.height);
  for (uint32_t y = 0, i = 0; y < window.size.height; ++y)
    for (uint32_t x = 0; x < window.size.width; ++x, ++i) {
      glm::vec2 t{};
      const vec3 dir = shared::pixel_direction(c, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      depth_m[i] = shared::intersect_shell(c.planet, dir, 0.0f, t) && t.x > 0.0f ? t.x : shared::kFarDepth_m;
    }
  view.depth_m = device.create_image({.name = "slab.depth_m", .extent = window.size, .format = Format::r32f});
  const gpu::ImageUpload upload{.image = &view.depth_m, .bytes = std::as_bytes(std::span(depth_m))};
  device.upload({&upload, 1});
  return view;
}

/// What each pixel's radiance adds to the flux through a horizontal plane.
std::vector<double> flux_weights(const Window& w) {
  std::vector<double> weights;
  const double volume = std::abs(glm::dot(w.forward, glm::cross(w.right, w.up)));
  for (uint32_t y = 0; y < w.size.height; ++y)
    for (uint32_t x = 0; x < w.size.width; ++x) {
      const dvec3 v =
          w.forward + (2.0 * (x + 0.5) / w.size.width - 1.0) * w.right + (1.0 - 2.0 * (y + 0.5) / w.size.height) * w.up;
      const double length = glm::length(v);
      const double solid_angle = volume * 4.0 / (w.size.width * w.size.height) / (length * length * length);
      weights.push_back(2.0 * solid_angle * std::abs(glm::dot(v, kUp)) / length);
    }
  return weights;
}

/// The view from below that looks at the sun.
Window sun_window(double mu0) { return window_of({.up = false, .mu = mu0, .phi_deg = 0.0}); }

/// Pixels along a cube's face. The sum over them is a midpoint rule: with g 0.85 24 of them give fluxes within 0.3 % of
/// those of 128, and the error falls as their square. Peaks of scattering are about 1 - |g| wide.
uint32_t face_px_for(double g) {
  const double wanted = 3.0 / std::max(1.0 - std::abs(g), 1e-3);
  return std::clamp(8u * static_cast<uint32_t>(std::ceil(wanted / 8.0)), 24u, 256u);
}

struct Hemispheres {
  std::vector<View> views;
  std::vector<std::vector<double>> weights;
};

}  // namespace

std::string SlabDirection::name() const { return fmt::format("{}_mu{:.1f}_phi{:.0f}", up ? "up" : "dn", mu, phi_deg); }

const std::array<SlabDirection, kSlabDirections>& slab_directions() {
  static const std::array<SlabDirection, kSlabDirections> all = [] {
    std::array<SlabDirection, kSlabDirections> directions;
    size_t i = 0;
    for (const bool up : {true, false})
      for (const double mu : {0.1, 0.3, 0.5, 0.7, 0.9, 1.0})
        for (const double phi_deg : {0.0, 90.0, 180.0}) directions[i++] = {up, mu, phi_deg};
    return directions;
  }();
  return all;
}

CloudParams slab_clouds(const Slab& slab) {
  CloudParams params;
  const double extinction_per_m = slab.tau / (kSlabTop_m - kSlabBase_m);
  params.coverage = 1.0;
  params.uniform_density = 1.0;
  params.layers = {CloudLayer{.base_m = kSlabBase_m, .thickness_m = kSlabTop_m - kSlabBase_m}};
  params.scattering_per_m = extinction_per_m * slab.single_scattering_albedo;
  params.absorption_per_m = extinction_per_m * (1.0 - slab.single_scattering_albedo);
  params.phase_g_forward = slab.g;
  params.phase_backward_weight = 0.0;
  if (slab.droplet_diameter_um > 0.0) {
    params.phase = "mie";
    params.droplet_diameter_um = slab.droplet_diameter_um;
  }
  params.sky_light_scale = 0.0;
  params.ground_bounce_scale = 0.0;
  return params;
}

shared::CloudConstants slab_constants(const Clouds& clouds, const Slab& slab) {
  shared::CloudConstants c = clouds.constants();
  const CloudParams params = slab_clouds(slab);
  const double extinction_per_m = params.scattering_per_m + params.absorption_per_m;
  c.layers[0].extinction_per_m = static_cast<float>(extinction_per_m);
  c.layers[0].step_m =
      static_cast<float>(march_step_m(params.layers[0].cell_size_m, static_cast<double>(c.layers[0].extinction_per_m)));
  c.extinction_unit_per_m = static_cast<float>(extinction_per_m);
  c.single_scattering_albedo = static_cast<float>(params.scattering_per_m / extinction_per_m);
  c.phase = droplet_phase(params).constants();
  return c;
}

/// The layer is the same everywhere: few columns do, and light fades within metres of the faces of the densest.
constexpr CloudLight::Quality kSlabLight{.paths = 4,
                                         .node_px = 1,
                                         .grid_texels = 16,
                                         .grid_slices = 512,
                                         .finest_half_m = 64e3f,
                                         .first_m = 2.0f,
                                         .first_paths = 0.25f,
                                         .all_around = true};
/// Frames of one direction need few nodes; but no others share their noise.
constexpr CloudLight::Quality narrow(CloudLight::Quality quality) {
  quality.node_px = kDirectionSize.height;
  quality.paths = 16;
  return quality;
}

struct MarchedSlabs::Parts {
  Parts(gpu::Device& gpu_device, const CloudParams& params, uint32_t px)
      : device(gpu_device),
        face_px(px),
        clouds(device, params),
        light{CloudLight(device, clouds, kSpectralGroups, kSlabLight),
              CloudLight(device, clouds, kSpectralGroups, kSlabLight),
              CloudLight(device, clouds, kSpectralGroups, narrow(kSlabLight)),
              CloudLight(device, clouds, kSpectralGroups, narrow(kSlabLight))},
        march(device, clouds, kSpectralGroups, true),
        executor(device) {
    for (const SlabDirection& d : slab_directions()) directions.push_back(view_of(device, window_of(d), d.up));
  }

  const Hemispheres& hemispheres(uint32_t px) {
    Hemispheres& h = by_px[px];
    if (h.views.empty())
      for (const bool up : {true, false})
        for (const Window& window : hemisphere(up ? kUp : -kUp, px)) {
          h.views.push_back(view_of(device, window, up));
          h.weights.push_back(flux_weights(window));
        }
    return h;
  }

  SlabLight solve(const Slab& slab);

  gpu::Device& device;
  uint32_t face_px;
  Clouds clouds;
  CloudLight light[4];  ///< of the cameras below and above: of hemispheres, then of single directions
  CloudMarchPass march;
  gpu::GraphExecutor executor;
  std::vector<View> directions;
  std::map<uint32_t, Hemispheres> by_px;
};

SlabLight MarchedSlabs::Parts::solve(const Slab& slab) {
  const Hemispheres& h = hemispheres(face_px != 0 ? face_px : face_px_for(slab.g));
  const View sun = view_of(device, sun_window(slab.mu0), false);
  std::vector<const View*> views;
  for (const View& view : directions) views.push_back(&view);
  for (const View& view : h.views) views.push_back(&view);
  views.push_back(&sun);

  FrameGraph graph;
  const WeatherMap::Refs weather = clouds.weather().import_into(graph);
  const CloudNoise::Refs noise = clouds.noise().import_into(graph);
  CloudDensityRefs density[2];
  for (const bool above : {false, true}) {
    CloudParams params = slab_clouds(slab);
    params.multiple_scattering = clouds.params().multiple_scattering;
    light[above ? 1 : 0].renew(params);
    light[above ? 3 : 2].renew(params);
    shared::CloudConstants constants = slab_constants(clouds, slab);
    constants.anchor = clouds.anchor(camera_ecef(above), 0.0);
    density[above] = {.constants = graph.constants("clouds.constants", constants), .weather = weather, .noise = noise};
  }
  const vec3 sun_dir = vec3(slab.mu0 * kUp - std::sqrt(std::max(1.0 - slab.mu0 * slab.mu0, 0.0)) * kEast);
  const glm::uvec2 narrow_size{kDirectionSize.width, kDirectionSize.height};
  std::vector<ImageRef> lights;
  for (const View* view : views) {
    FrameInfo frame;
    frame.extent = {view->constants.size.x, view->constants.size.y};
    frame.constants = view->constants;
    frame.constants.sun_dir = frame.constants.key_dir = sun_dir;
    frame.camera_ecef_m = camera_ecef(view->above);
    frame.buffer = graph.constants("frame", frame.constants);
    const ImageRef depth_m = graph.import(view->depth_m);
    const CloudLight::Refs traced = light[(view->above ? 1 : 0) + (view->constants.size == narrow_size ? 2 : 0)].add(
        graph, frame, {.depth_m = depth_m, .density = density[view->above]});
    lights.push_back(
        march.add_march(graph, frame, {.depth_m = depth_m, .density = density[view->above], .light = traced}).light);
    graph.keep(lights.back());
  }
  executor.run(graph);

  // Per pixel: share of the sun's light, 1/sr; of the sky's; of the ground's; transmittance.
  const auto mean = [&](ImageRef image, size_t channel) {
    const std::vector<float> texels = executor.read<float>(image);
    double sum = 0.0;
    for (size_t i = channel; i < texels.size(); i += 4) sum += static_cast<double>(texels[i]);
    return 4.0 * sum / static_cast<double>(texels.size());
  };
  SlabLight out;
  for (size_t i = 0; i < kSlabDirections; ++i) out.radiance[i] = mean(lights[i], 0);
  for (size_t i = 0; i < h.views.size(); ++i) {
    const std::vector<float> texels = executor.read<float>(lights[kSlabDirections + i]);
    double flux = 0.0;
    for (size_t k = 0; k < h.weights[i].size(); ++k) flux += h.weights[i][k] * static_cast<double>(texels[4 * k]);
    (h.views[i].above ? out.reflectance : out.transmittance_diffuse) += flux / slab.mu0;
  }
  out.transmittance_direct = mean(lights.back(), 3);
  return out;
}

MarchedSlabs::MarchedSlabs(gpu::Device& device, const std::string& multiple_scattering, uint32_t face_px) {
  CloudParams params = slab_clouds({});
  params.multiple_scattering = multiple_scattering;
  parts_ = std::make_unique<Parts>(device, params, face_px);
}
MarchedSlabs::~MarchedSlabs() = default;

std::vector<SlabLight> MarchedSlabs::solve(std::span<const Slab> slabs) {
  Progress progress("slabs");
  std::vector<SlabLight> lights;
  for (const Slab& slab : slabs) {
    lights.push_back(parts_->solve(slab));
    progress.update(static_cast<double>(lights.size()) / static_cast<double>(slabs.size()));
  }
  return lights;
}

}  // namespace nepho
