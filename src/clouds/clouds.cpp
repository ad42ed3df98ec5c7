#include "clouds/clouds.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "base/error.h"
#include "base/log.h"
#include "clouds/cloud_anchor.h"
#include "clouds/cloud_calibrate.comp.h"
#include "clouds/cloud_density.h"
#include "clouds/droplet_phase.h"
#include "geo/planet_view.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "base/blob_cache.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::CloudLayerConstants) == 19 * 4 + 2 * 16 + 2 * 8 + 4 * 4 + 16 * 4 + 4);
static_assert(sizeof(shared::CloudConstants) ==
              26 * 40 + 4 * sizeof(shared::CloudLayerConstants) + sizeof(shared::CloudAnchor) + 40 + 16 * 4 + 28 + 24);

constexpr double kLifetime_s = 2400.0;  ///< in which a cell's slice moves by a cell, at evolution_speed 1
constexpr double kLean_s = 600.0;       ///< of shear that tops lean by: a cell's age
constexpr uint32_t kCalibrationColumns = 16384;
constexpr float kCalibrationFootprint_m = 10.0f;

/// Weights of the fields: what the weather map resolves itself, noise adds no more to.
void set_weights(shared::CloudLayerConstants& to, double weather_texel_m) {
  const double regional = 0.36 * std::clamp((weather_texel_m - 30e3) / 60e3, 0.0, 1.0);
  const double meso = 0.55 * std::clamp(weather_texel_m / 8e3, 0.25, 1.0), cell = 0.75;
  const double norm = 1.0 / std::sqrt(regional * regional + meso * meso + cell * cell);
  to.regional_weight = static_cast<float>(regional * norm);
  to.meso_weight = static_cast<float>(meso * norm);
  to.cell_weight = static_cast<float>(cell * norm);
}

shared::CloudLayerConstants layer_constants(const CloudLayer& layer, uint32_t slot, const CloudParams& params,
                                            const WeatherMap& weather) {
  shared::CloudLayerConstants c{};
  const auto f = [](double v) { return static_cast<float>(v); };
  c.base_m = f(layer.base_m);
  c.thickness_m = f(layer.thickness_m);
  c.extinction_per_m = f(layer.density_scale * (params.scattering_per_m + params.absorption_per_m));
  c.shape_amount = f(layer.shape_amount);
  c.detail_amount = f(layer.detail_amount);
  c.filter_width = f(layer.coverage_filter_width);
  c.top_relief = f(layer.top_relief);
  c.anvil_amount = f(layer.anvil_amount);
  c.altering_bias = f(layer.shape_altering_bias);
  c.cell_roundness = f(layer.cell_roundness);
  c.cell_size_m = f(layer.cell_size_m);
  c.cover_optical_depth = f(layer.cover_optical_depth);
  c.weather_exponent = f(layer.weather_exponent);
  c.coverage_scale = f(layer.coverage_scale);
  c.geoid_weight = layer.base_reference == "msl" ? 1.0f : 0.0f;
  c.ground_weight = layer.base_reference == "terrain" ? 1.0f : 0.0f;
  set_weights(c, weather.texel_m());
  const auto channel = static_cast<int>(std::string("rgba").find(layer.weather_channel));
  c.channel[channel] = 1.0f;
  const DensityProfile& p = layer.density_profile;
  c.profile = glm::vec4(f(p.exp_term), f(p.exponent), f(p.linear_term), f(p.constant_term));
  c.wind_mps = glm::vec2(f(layer.wind_east_mps), f(layer.wind_north_mps));
  c.lean = glm::vec2(f(layer.shear_east_mps_per_km), f(layer.shear_north_mps_per_km)) * f(1e-3 * kLean_s);
  c.evolution_mps = f(layer.evolution_speed * layer.cell_size_m / kLifetime_s);
  c.step_m = f(march_step_m(layer.cell_size_m, static_cast<double>(c.extinction_per_m)));
  c.bend_m = glm::vec2(1500.0f, f(0.07 * layer.cell_size_m));
  for (int i = 0; i < 16; ++i) c.thresholds[i] = shared::kThresholdFirst + shared::kThresholdStep * f(i);
  c.slot = slot;
  return c;
}

glm::vec2 fade_of(const CloudNoise::Fade& fade) { return {fade.start, fade.per_lod}; }

}  // namespace

double march_step_m(double cell_size_m, double extinction_per_m) {
  return std::max(36.0 * std::sqrt(cell_size_m / 2500.0), std::min(0.1 / std::max(extinction_per_m, 1e-6), 250.0));
}

std::vector<uint32_t> drawing_layers(const CloudParams& params) {
  std::vector<uint32_t> drawing;
  if (params.coverage && *params.coverage <= 0.0) return drawing;
  for (uint32_t i = 0; i < params.layers.size() && i < shared::kCloudLayers; ++i) {
    const CloudLayer& layer = params.layers[i];
    const bool draws = layer.thickness_m > 0.0 && layer.density_scale > 0.0 && layer.coverage_scale > 0.0 &&
                       params.scattering_per_m + params.absorption_per_m > 0.0;
    if (draws) drawing.push_back(i);
  }
  return drawing;
}

bool draws_nothing(const CloudParams& params) { return drawing_layers(params).empty(); }

Clouds::Clouds(gpu::Device& device, const CloudParams& params, const WeatherSources& sources)
    : params_(params), noise_(device, params.noise), weather_(device) {
  weather_.update(params, sources);
  shared::CloudConstants& c = constants_;
  std::vector<CloudLayer> layers;
  double low = 1e9, high = -1e9;
  for (const uint32_t slot : drawing_layers(params)) {
    const CloudLayer& layer = params.layers[slot];
    c.layers[layers.size()] = layer_constants(layer, slot, params, weather_);
    const WeatherMap::OffsetRange range = weather_.base_offset_range(layer.base_reference);
    layer_ranges_.push_back({layer.base_m + range.low_m, layer.base_m + layer.thickness_m + range.high_m});
    low = std::min(low, layer_ranges_.back().low_m);
    high = std::max(high, layer_ranges_.back().high_m);
    if (layer.casts_shadow) c.casters[c.caster_count++] = static_cast<uint32_t>(layers.size());
    layers.push_back(layer);
  }
  lattices_ = make_cloud_lattices(params, layers,
                                  {.shape = noise_.shape_size(),
                                   .detail = noise_.detail_size(),
                                   .turbulence = noise_.turbulence_size(),
                                   .tile = std::max(weather_.tile().desc().extent.width, 1u)});
  for (uint32_t d = 0; d < shared::kCloudDomains; ++d) {
    c.domains[d].uvw_from_ecef = glm::mat3(lattices_[d].uvw_from_ecef);
    c.domains[d].log2_texel_m = static_cast<float>(std::log2(lattices_[d].texel_m));
  }
  const CloudNoise::Fades& fades = noise_.fades();
  c.fades = {fade_of(fades.field), fade_of(fades.cells_round), fade_of(fades.cells_fractal), fade_of(fades.shape),
             fade_of(fades.detail)};
  c.layer_count = static_cast<uint32_t>(layers.size());
  c.hull_low_m = layers.empty() ? 0.0f : static_cast<float>(low);
  c.hull_high_m = layers.empty() ? 1.0f : static_cast<float>(high);
  c.uniform_coverage = static_cast<float>(params.coverage.value_or(0.0));
  c.log2_weather_texel_m = static_cast<float>(std::log2(weather_.texel_m()));
  const double extinction = params.scattering_per_m + params.absorption_per_m;
  c.single_scattering_albedo = extinction > 0.0 ? static_cast<float>(params.scattering_per_m / extinction) : 1.0f;
  c.extinction_unit_per_m = extinction > 0.0 ? static_cast<float>(extinction) : 1.0f;
  c.phase = droplet_phase(params).constants();
  c.multiple_scattering_weight = static_cast<float>(params.multiple_scattering_weight);
  c.powder = static_cast<float>(params.powder);
  c.uniform_density = static_cast<float>(params.uniform_density);
  c.shape_displacement_m = static_cast<float>(params.noise.shape.displacement_m);
  c.detail_displacement_m = static_cast<float>(params.noise.detail.displacement_m);
  c.fine_displacement_m = 0.45f * c.detail_displacement_m;
  c.shape_velocity_mps = glm::vec3(params.noise.shape.velocity_mps);
  c.detail_velocity_mps = glm::vec3(params.noise.detail.velocity_mps);
  if (!layers.empty() && params.uniform_density <= 0.0) calibrate(device);
}

uint32_t Clouds::phases_at(double time_s) const { return cloud_phases(time_s).count; }

std::vector<uint32_t> Clouds::specialisation(uint32_t phases) const {
  const uint32_t kind = params_.coverage ? 0u : params_.weather.source == "tile" ? 2u : 1u;
  bool ground = false;
  for (const uint32_t slot : drawing_layers(params_))
    ground = ground || params_.layers[slot].base_reference != "ellipsoid";
  return {0u,
          std::max(constants_.layer_count, 1u),
          phases,
          kind,
          ground ? 1u : 0u,
          params_.multiple_scattering == "octaves" ? 1u : 0u,
          params_.sun_taps == "cone" ? 1u : 0u};
}

std::optional<uint64_t> Clouds::calibration_key() const {
  const CloudNoiseParams& noise = params_.noise;
  for (const std::string* file : {&noise.shape.file, &noise.detail.file, &noise.turbulence.file})
    if (!file->empty()) return std::nullopt;  // a file may change behind its name
  // What the calibration reads: all constants but camera and clock, where the lattices start, and the shader itself.
  shared::CloudConstants constants = constants_;
  constants.anchor = make_cloud_anchor(lattices_, params_, dvec3(0.0), 0.5 * kWindow_s);
  constants.phase = {};  // light is not asked for
  constants.multiple_scattering_weight = constants.powder = 0.0f;
  const auto bytes = std::as_bytes(std::span(&constants, 1));
  const auto shader = std::as_bytes(std::span(cloud_calibrate_comp));
  return checksum_of(bytes.data(), bytes.size()) ^ (31 * checksum_of(shader.data(), shader.size()));
}

void Clouds::calibrate(gpu::Device& device) {
  const std::optional<uint64_t> key = calibration_key();
  const std::string file = key ? fmt::format("cloud_thresholds_{:016x}.bin", *key) : "";
  constexpr size_t kBytes = sizeof(shared::CloudLayerConstants::thresholds);
  if (key)
    if (const auto cached = load_cached_blob(file, *key); cached && cached->size() == kBytes * constants_.layer_count) {
      for (uint32_t l = 0; l < constants_.layer_count; ++l)
        std::memcpy(constants_.layers[l].thresholds, cached->data() + l * kBytes, kBytes);
      return;
    }
  if (!measure_thresholds(device) || !key) return;
  std::vector<std::byte> blob(kBytes * constants_.layer_count);
  for (uint32_t l = 0; l < constants_.layer_count; ++l)
    std::memcpy(blob.data() + l * kBytes, constants_.layers[l].thresholds, kBytes);
  store_cached_blob(file, *key, blob);
}

bool Clouds::measure_thresholds(gpu::Device& device) {
  const gpu::ComputePipeline pipeline(
      device, {.name = "clouds.calibrate", .spirv = cloud_calibrate_comp, .constants = specialisation(1)});
  // A camera at the Earth's centre: columns are anywhere, and their place to half a metre is enough.
  shared::FrameConstants frame{};
  frame.planet = make_planet_view(dvec3(0.0));
  shared::CloudConstants constants = constants_;
  constants.anchor = make_cloud_anchor(lattices_, params_, dvec3(0.0), 0.5 * kWindow_s);
  FrameGraph graph;
  const BufferRef frame_buffer = graph.constants("frame", frame);
  const CloudDensityRefs refs{.constants = graph.constants("clouds.constants", constants),
                              .weather = weather_.import_into(graph),
                              .noise = noise_.import_into(graph)};
  std::vector<BufferRef> results;
  for (uint32_t l = 0; l < constants_.layer_count; ++l) {
    const BufferRef out = graph.create_buffer("clouds.critical", kCalibrationColumns * sizeof(float));
    struct Push {
      uint32_t layer, count;
      float footprint_m;
    } push{l, kCalibrationColumns, kCalibrationFootprint_m};
    FrameGraph::PassBuilder pass = graph.pass("clouds.calibrate");
    pass.uniform("frame", frame_buffer);
    bind_density(pass, refs);
    pass.write("critical", out).record([&pipeline, push](gpu::Commands& cmd) {
      cmd.bind(pipeline).push(push).dispatch_threads(push.count, 1);
    });
    graph.keep(out);
    results.push_back(out);
  }
  gpu::GraphExecutor executor(device);
  executor.run(graph);
  bool all_reach = true;
  for (uint32_t l = 0; l < constants_.layer_count; ++l) {
    std::vector<float> critical = executor.read<float>(results[l]);
    std::sort(critical.begin(), critical.end());
    float* thresholds = constants_.layers[l].thresholds;
    for (int i = 0; i < 16; ++i) {
      const float z = shared::kThresholdFirst + shared::kThresholdStep * static_cast<float>(i);
      const double at = static_cast<double>(shared::share_from_probit(z)) * (kCalibrationColumns - 1.0);
      const auto k = std::min<size_t>(static_cast<size_t>(at), kCalibrationColumns - 2);
      thresholds[i] = critical[k] + static_cast<float>(at - static_cast<double>(k)) * (critical[k + 1] - critical[k]);
    }
    if (critical[kCalibrationColumns / 2] > 5.5f) {
      all_reach = false;
      log_warning(
          "clouds.layers[{}]: its columns do not reach the optical depth {} that counts as covered; raise "
          "density_scale "
          "or thickness_m, or lower cover_optical_depth",
          constants_.layers[l].slot, constants_.layers[l].cover_optical_depth);
      for (int i = 0; i < 16; ++i)
        thresholds[i] = shared::kThresholdFirst + shared::kThresholdStep * static_cast<float>(i);
    }
  }
  return all_reach;
}

}  // namespace nepho
