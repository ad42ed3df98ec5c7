#include "render/night_sky.h"

#include "render/frame_setup.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "astro/moonlight.h"
#include "gpu/commands.h"
#include "render/star_splat.comp.h"

namespace nepho {

static_assert(sizeof(shared::NightSkyUniform) == 132);
static_assert(sizeof(shared::StarOnGpu) == 32);
static_assert(sizeof(shared::StarSplatPush) == 44);

namespace {

constexpr uint32_t kMoonMapWidth = 2048, kMoonCoarseWidth = 256;
constexpr double kMoonGeometricAlbedo = 0.12;  // V; Allen
constexpr double kStarsAppear_rad = -2.0 * std::numbers::pi / 180.0;
// Sums of all stars must fit 32 bits, whatever the field of view puts into one pixel.
constexpr double kLargestSum = 4.0e9, kFinestUnit_lux = 1.0e-13;

/// Halves a map; its width and height are powers of two.
MoonMap halved(const MoonMap& from) {
  MoonMap to{from.width / 2, from.height / 2, {}};
  to.albedo.resize(size_t{to.width} * to.height);
  for (size_t j = 0; j < to.height; ++j)
    for (size_t i = 0; i < to.width; ++i) {
      const float* at = &from.albedo[2 * j * from.width + 2 * i];
      to.albedo[j * to.width + i] = 0.25f * (at[0] + at[1] + at[from.width] + at[from.width + 1]);
    }
  return to;
}

}  // namespace

double mean_over_moon_disc(const MoonMap& map, const dmat3& moon_from_ecef, const dvec3& moon_dir, const dvec3& light,
                           double lunar_lambert) {
  constexpr int kLongitudes = 64, kLatitudes = 48;
  constexpr double kHalfTurn = std::numbers::pi;
  // Longitudes about the axis that sun and camera stand square to: the lit, visible part is a lune between two of them.
  const dvec3 view = -moon_dir;
  const double cos_phase = std::clamp(glm::dot(view, light), -1.0, 1.0), phase = std::acos(cos_phase);
  dvec3 aside = light - cos_phase * view;
  if (glm::length(aside) < 1e-9) aside = glm::cross(view, std::abs(view.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0));
  aside = glm::normalize(aside);
  const dvec3 axis = glm::cross(view, aside);
  const double first = phase - 0.5 * kHalfTurn, width = kHalfTurn - phase;
  double sum = 0.0;
  for (int j = 0; j < kLatitudes; ++j) {
    const double lat = ((j + 0.5) / kLatitudes - 0.5) * kHalfTurn;
    for (int i = 0; i < kLongitudes; ++i) {
      const double lon = first + (i + 0.5) / kLongitudes * width;
      const dvec3 n = std::cos(lat) * (std::cos(lon) * view + std::sin(lon) * aside) + std::sin(lat) * axis;
      const double mu = std::cos(lat) * std::cos(lon), mu_0 = std::cos(lat) * std::cos(lon - phase);
      const dvec3 body = moon_from_ecef * n;
      const double albedo =
          static_cast<double>(map.at(std::asin(std::clamp(body.z, -1.0, 1.0)), std::atan2(body.y, body.x)));
      const double shading = static_cast<double>(
          shared::lunar_shading(static_cast<float>(mu_0), static_cast<float>(mu), static_cast<float>(lunar_lambert)));
      sum += albedo * shading * mu * std::cos(lat);
    }
  }
  return sum * (width / kLongitudes) * (kHalfTurn / kLatitudes) / kHalfTurn;  // projected areas; the disc's is pi
}

NightSky::NightSky(gpu::Device& device, const SkySources& sources)
    : device_(device), splat_(device, {.name = "stars.splat", .spirv = star_splat_comp}) {
  load_moon(sources.moon_texture ? read_moon_map(*sources.moon_texture, kMoonMapWidth) : MoonMap{});
  load_stars(sources.stars);
}

void NightSky::load_moon(const MoonMap& map) {
  std::vector<std::vector<uint8_t>> mips;
  MoonMap level = map;
  while (true) {
    if (level.width <= kMoonCoarseWidth && moon_coarse_.width == 1) moon_coarse_ = level;
    std::vector<uint8_t>& texels = mips.emplace_back();
    for (const float a : level.albedo)
      texels.push_back(static_cast<uint8_t>(std::clamp(a, 0.0f, 1.0f) * 255.0f + 0.5f));
    if (level.height <= 1) break;
    level = halved(level);
  }
  moon_map_ = device_.create_image({.name = "moon.map",
                                    .extent = {map.width, map.height},
                                    .format = Format::r8,
                                    .mip_levels = static_cast<uint32_t>(mips.size())});
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t m = 0; m < mips.size(); ++m) uploads.push_back({&moon_map_, std::as_bytes(std::span(mips[m])), m, 0});
  device_.upload(uploads);
}

void NightSky::load_stars(const std::vector<Star>& stars) {
  std::vector<shared::StarOnGpu> on_gpu;
  dvec3 total_lux(0.0);
  for (const Star& s : stars) {
    const double lux = star_illuminance_lux(s.magnitude);
    on_gpu.push_back({vec3(s.dir_icrs), static_cast<float>(lux), s.color, 0.0f});
    total_lux += lux * dvec3(s.color);
  }
  star_count_ = static_cast<uint32_t>(on_gpu.size());
  const double unit_lux = std::max(kFinestUnit_lux, std::max({total_lux.x, total_lux.y, total_lux.z}) / kLargestSum);
  units_per_lux_ = static_cast<float>(1.0 / unit_lux);
  if (on_gpu.empty()) on_gpu.push_back({vec3(1.0f, 0.0f, 0.0f), 0.0f, vec3(1.0f), 0.0f});
  const std::array<uint32_t, 3> none{};
  stars_ = device_.create_buffer({.name = "stars.catalog", .size_bytes = on_gpu.size() * sizeof(shared::StarOnGpu)});
  no_star_pixels_ = device_.create_buffer({.name = "stars.none", .size_bytes = sizeof(none)});
  const gpu::BufferUpload uploads[] = {{&stars_, 0, std::as_bytes(std::span(on_gpu))},
                                       {&no_star_pixels_, 0, std::as_bytes(std::span(none))}};
  device_.upload({}, uploads);
}

bool NightSky::shows(const shared::FrameConstants& frame) {
  const double sine = static_cast<double>(glm::dot(frame.camera_up, frame.sun_dir));
  return frame.planet.camera_height_m > static_cast<float>(kNightSkyAbove_m) || sine < std::sin(kStarsAppear_rad);
}

bool NightSky::draws_stars(const shared::FrameConstants& frame, const NightSkyParams& params) {
  return params.stars && shows(frame);
}

shared::NightSkyUniform NightSky::uniform(const shared::FrameConstants& frame, const NightSkyParams& params,
                                          const SkyBodies& sky) const {
  shared::NightSkyUniform n{};
  const MoonState& moon = sky.moon;
  const dvec3 moon_dir(frame.moon_dir);
  const double radius = static_cast<double>(frame.moon_angular_radius_rad);
  n.moon_from_ecef = glm::mat3(moon.body_from_ecef);
  n.sun_from_moon = vec3(moon.sun_from_moon_ecef);
  const double phase = std::acos(std::clamp(glm::dot(moon.sun_from_moon_ecef, -moon_dir), -1.0, 1.0));
  n.lunar_lambert = shared::lunar_lambert_share(static_cast<float>(phase));
  if (params.moon) {
    const double lambert = static_cast<double>(n.lunar_lambert);
    const double mean =
        mean_over_moon_disc(moon_coarse_, moon.body_from_ecef, moon_dir, moon.sun_from_moon_ecef, lambert);
    const double albedo = mean_over_moon_disc(moon_coarse_, moon.body_from_ecef, moon_dir, -moon_dir, 1.0);
    const dvec3 sun(frame.sun_illuminance_1au);
    n.moon_mean = static_cast<float>(mean);
    n.moon_mean_albedo = static_cast<float>(albedo);
    // Whatever the law of reflection makes of the phase, the disc's light is Allen's; by day too, when frame.moon_share
    // is not yet all of it.
    const dvec3 share =
        moon_sun_illuminance_ratio(phase, kMoonRadius_m / std::sin(radius), moon.sun_distance_au) * moonlight_color();
    if (mean > 1e-9) n.moon_luminance = vec3(share * sun / (std::numbers::pi * radius * radius * mean));
    const dvec3 earthshine = earthshine_illuminance_ratio(moon.phase_angle_rad, moon.distance_m, sky.sun.distance_au) *
                             earthshine_color() * sun;
    n.earthshine_luminance = vec3(earthshine * (kMoonGeometricAlbedo / std::numbers::pi / albedo));
    n.moon_present = 1.0f;
  }
  n.airglow = static_cast<float>(params.airglow_cd_m2) * shared::airglow_color();
  n.night_illuminance = shared::night_sky_illuminance(static_cast<float>(params.airglow_cd_m2), params.stars);
  if (draws_stars(frame, params)) {
    n.starlight = vec3(shared::kStarlightLuminance_cd_m2);
    if (star_count_ > 0) {
      n.star_unit_lux = 1.0f / units_per_lux_;
      n.star_stride = 1;
    }
  }
  return n;
}

NightSky::Refs NightSky::add(FrameGraph& graph, const FrameInfo& frame, const NightSkyParams& params,
                             const SkyBodies& sky) const {
  const shared::NightSkyUniform n = uniform(frame.constants, params, sky);
  Refs refs;
  refs.uniform = graph.constants("night_sky", n);
  refs.moon_map = graph.import(moon_map_);
  if (n.star_stride == 0) {
    refs.star_pixels = graph.import(no_star_pixels_);
    return refs;
  }
  const uint32_t numbers = 3 * frame.extent.width * frame.extent.height;
  refs.star_pixels = graph.create_buffer("stars.pixels", uint64_t{numbers} * sizeof(uint32_t));
  graph.pass("stars.clear").zero("star_pixels", refs.star_pixels).record([](gpu::Commands& cmd) {
    cmd.zero("star_pixels");
  });
  const shared::StarSplatPush push{glm::mat3(sky.ecef_from_icrs), star_count_, units_per_lux_};
  graph.pass("stars.splat")
      .uniform("frame", frame.buffer)
      .read("stars", graph.import(stars_))
      .read_write("star_pixels", refs.star_pixels)
      .record([this, push](gpu::Commands& cmd) { cmd.bind(splat_).push(push).dispatch_threads(star_count_); });
  return refs;
}

void NightSky::bind(FrameGraph::PassBuilder& pass, const Refs& refs) {
  pass.uniform("night_sky", refs.uniform)
      .read("star_pixels", refs.star_pixels)
      .sample("moon_map", refs.moon_map, Sampler::linear_repeat_u);
}

}  // namespace nepho
