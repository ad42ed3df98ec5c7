#include "atmosphere/air_volume.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "atmosphere/air_volume.comp.h"
#include "atmosphere/light_tables.comp.h"
#include "atmosphere/sky_view.h"
#include "gpu/commands.h"

namespace nepho {

static_assert(sizeof(shared::AirVolumeLight) == 48);
static_assert(sizeof(shared::AirVolumeData) == 16 + 2 * 48 + 4 * 16);
static_assert(shared::kAirRows == shared::kAirSkyRows + shared::kAirGroundRows);

namespace {

constexpr uint32_t u32(int n) { return static_cast<uint32_t>(n); }

/// Lit points above this have light that the tables' rows are too far apart for.
constexpr double kHighestTabled_m = 25e3;
constexpr double kHighestGround_m = 9e3;
/// Sines of the sun's elevation at the camera between which light along a ray falls tenfold within a slice or two.
constexpr float kDuskBelow = -0.01f, kNightBelow = -0.31f;
/// Directions along each edge of the picture that say which part of the volume it sees.
constexpr int kLooks = 64;

/// Whether a direction is within the picture or just outside it.
bool shows(const shared::FrameConstants& frame, const glm::vec3& dir) {
  const float ahead = glm::dot(dir, frame.forward) / glm::dot(frame.forward, frame.forward);
  const float x = glm::dot(dir, frame.right) / glm::dot(frame.right, frame.right);
  const float y = glm::dot(dir, frame.up) / glm::dot(frame.up, frame.up);
  return ahead > 0.0f && std::max(std::abs(x), std::abs(y)) < 1.1f * ahead;
}

/// Texels of azimuth and row that a picture may read: those at its edge, between looks at most as far off as two looks
/// are apart; all around a pole that it shows.
glm::ivec4 window_of(const shared::AirVolumeData& volume, const shared::AirVolumeLight& light,
                     const shared::FrameConstants& frame) {
  constexpr auto last_azimuth = static_cast<float>(shared::kAirAzimuths - 1);
  constexpr auto last_sky = static_cast<float>(shared::kAirSkyRows - 1);
  constexpr auto last_ground = static_cast<float>(shared::kAirGroundRows - 1);
  const glm::vec2 corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  glm::vec2 low(1e9f), high(-1e9f), apart(0.0f), before(0.0f);
  for (int i = 0; i <= 4 * kLooks; ++i) {
    const int side = i / kLooks % 4;
    const glm::vec2 part =
        glm::mix(corners[side], corners[(side + 1) % 4], static_cast<float>(i % kLooks) / static_cast<float>(kLooks));
    const glm::vec3 scaled =
        scaled_from_cam(frame.planet, shared::pixel_direction(frame, part * glm::vec2(frame.size)));
    const shared::AirPlace place = shared::air_place(volume, glm::dot(scaled, light.forward),
                                                     glm::dot(scaled, light.side), glm::dot(scaled, volume.up));
    const glm::vec2 at(place.azimuth * last_azimuth,
                       place.down ? -1.0f - place.row * last_ground : place.row * last_sky);
    if (i > 0) apart = glm::max(apart, glm::abs(at - before));
    before = at;
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  const glm::vec3 zenith(volume.up.x, volume.up.y, volume.up.z / frame.planet.a_over_b);
  const bool above = shows(frame, zenith), below = shows(frame, -zenith);
  if (above || below) low.x = 0.0f, high.x = last_azimuth;
  if (above) high.y = last_sky;
  if (below) low.y = -1.0f - last_ground;
  return {glm::ivec2(glm::floor(low - apart)), glm::ivec2(glm::ceil(high + apart))};
}

}  // namespace

shared::AirVolumeData make_air_volume(const shared::AtmosphereUniform& air, const AtmosphereParams& params,
                                      const shared::FrameConstants& frame, double top_m) {
  const AtmosphereParams p = resolved(params);
  shared::AirVolumeData volume{};
  const double R = static_cast<double>(air.radius_m);
  const double h = std::max(static_cast<double>(scaled_height_from_f(frame.planet, frame.planet.camera_f_m2)), 0.0);
  volume.h = static_cast<float>(h);
  volume.up = glm::vec3(glm::normalize(glm::dvec3(frame.planet.camera_q_m)));
  const double dip_rad = std::acos((R + static_cast<double>(shared::kAirFloor_m)) / (R + h));
  volume.dip_t = static_cast<float>(std::tan(0.5 * dip_rad));
  // Air without gas or aerosol has none of their light either.
  volume.gas_per_m = glm::max(glm::vec3(p.rayleigh.scattering_per_m), glm::vec3(1e-12f));
  volume.aerosol_per_m = glm::max(glm::vec3(p.mie.extinction_per_m), glm::vec3(1e-12f));
  volume.table_top_m = static_cast<float>(std::max(top_m, kHighestGround_m) * 1.01);
  const double reach_rad = std::acos(R / (R + h)) + std::acos(R / (R + static_cast<double>(volume.table_top_m))) + 0.01;
  const glm::vec3 directions[] = {frame.key_dir, frame.sun_dir, frame.moon_dir};
  for (int i = 0; i < 3; ++i) {
    const double zenith =
        std::acos(std::clamp(static_cast<double>(glm::dot(frame.camera_up, directions[i])), -1.0, 1.0));
    const double highest = std::cos(std::max(zenith - reach_rad, 0.0));
    const double lowest = std::cos(std::min(zenith + reach_rad, static_cast<double>(shared::kPi)));
    volume.mu_low[i] = static_cast<float>(lowest);
    volume.mu_span[i] = static_cast<float>(highest - lowest);
  }
  for (int i = 0; i < 2; ++i) {
    shared::AirVolumeLight& light = volume.lights[i];
    const shared::SkyView view = make_sky_view(air, frame.planet, frame.camera_up, directions[i + 1], 0, 1);
    light.forward = view.forward;
    light.side = view.side;
    light.mu_s = view.mu_s;
    light.window = window_of(volume, light, frame);
  }
  return volume;
}

AirVolume::AirVolume(gpu::Device& device, uint32_t spectral_groups)
    : fill_(device, {.name = "atmosphere.air_volume", .spirv = air_volume_comp, .constants = {spectral_groups}}),
      tables_(device, {.name = "atmosphere.light_tables", .spirv = light_tables_comp, .constants = {spectral_groups}}) {
}

bool AirVolume::serves(const shared::AtmosphereUniform& air, const shared::FrameConstants& frame, double top_m) {
  const float sun = glm::dot(frame.camera_up, frame.sun_dir);
  const bool dusk = sun < kDuskBelow && sun > kNightBelow;
  return has_sky_view(air, frame.planet) && top_m <= kHighestTabled_m && !dusk;
}

AirVolume::Refs AirVolume::add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereTables& tables,
                               const AtmosphereTables::Refs& atmosphere, double top_m) const {
  const uint32_t lights = frame.constants.light_count;
  const Refs out{
      .data = graph.constants("air_volume", make_air_volume(tables.uniform(), tables.params(), frame.constants, top_m)),
      .volume = graph.create("atmosphere.air_volume",
                             {.extent = {u32(2 * shared::kAirAzimuths), u32(shared::kAirParts * shared::kAirRows),
                                         u32(shared::kAirSlices)},
                              .format = Format::rgba32f}),
      .tables = graph.create("atmosphere.light_tables",
                             {.extent = {u32(shared::kLightMu), u32(shared::kLightTables * shared::kLightHeights)},
                              .format = Format::rgba32f})};
  graph.pass("atmosphere.air_volume")
      .uniform("frame", frame.buffer)
      .uniform("atmosphere", atmosphere.params)
      .uniform("air_volume", out.data)
      .sample("transmittance_tex", atmosphere.transmittance)
      .sample("source_tex", atmosphere.source)
      .write("out_volume", out.volume)
      .record([this, lights](gpu::Commands& cmd) {
        cmd.bind(fill_).dispatch_threads(u32(shared::kAirAzimuths * shared::kAirSlices), u32(shared::kAirRows), lights);
      });
  auto fill = graph.pass("atmosphere.light_tables");
  fill.uniform("frame", frame.buffer).uniform("air_volume", out.data).write("out_tables", out.tables);
  AtmosphereTables::bind(fill, atmosphere);
  fill.record([this](gpu::Commands& cmd) {
    cmd.bind(tables_).dispatch_threads(u32(shared::kLightMu), u32(shared::kLightHeights));
  });
  return out;
}

void AirVolume::bind(FrameGraph& graph, FrameGraph::PassBuilder& pass, const Refs& refs,
                     const AtmosphereTables::Refs& atmosphere) {
  pass.uniform("air_volume", refs ? refs.data : graph.constants("air_volume", shared::AirVolumeData{}))
      .sample("air_volume_tex", refs ? refs.volume : atmosphere.source)
      .sample("light_table_tex", refs ? refs.tables : atmosphere.transmittance);
}

}  // namespace nepho
