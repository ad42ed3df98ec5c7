#include "weather/weather_generator.h"

#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <numbers>
#include <random>

#include "base/error.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "base/blob_cache.h"
#include "weather/coverage_statistics.h"
#include "weather/cube_field.h"
#include "weather/weather_flow.comp.h"
#include "weather/weather_generate.comp.h"
#include "weather/weather_noise.comp.h"
#include "weather/weather_shared.h"
#include "weather/weather_trace.comp.h"

namespace nepho {

namespace {

constexpr uint64_t kGeneratorVersion = 7;
constexpr uint32_t kFlowSize = 128;
constexpr uint32_t kNoiseSize = 64;
static_assert(sizeof(shared::WeatherGenerate) == shared::kWeatherVortices * 24 + shared::kWeatherDecks * 16 + 8);

vec3 direction(double lat_deg, double lon_deg) {
  const double lat = rad_from_deg(lat_deg), lon = rad_from_deg(lon_deg);
  return {static_cast<float>(std::cos(lat) * std::cos(lon)), static_cast<float>(std::cos(lat) * std::sin(lon)),
          static_cast<float>(std::sin(lat))};
}

shared::WeatherGenerate generator_parameters(uint32_t size, uint32_t seed) {
  shared::WeatherGenerate g{};
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  uint32_t count = 0;
  const auto add = [&](double lat_deg, double lon_deg, double turn, double radius, bool tropical = false) {
    NEPHO_ASSERT_OP(count, <, shared::kWeatherVortices);
    g.vortices[count++] = {.centre = direction(lat_deg, lon_deg),
                           .turn = static_cast<float>(turn),
                           .radius = static_cast<float>(radius),
                           .tropical = tropical ? 1.0f : 0.0f};
  };
  // Cyclones turn counter-clockwise in the north (side 1), highs the other way. Young ones have hardly turned, old
  // ones are spirals. Each is followed by a smaller one on its trailing front, and by a high on the equator's side.
  for (const double side : {1.0, -1.0}) {
    const int trains = side > 0 ? 7 : 8;
    const double first = between(0.0, 360.0);
    for (int i = 0; i < trains; ++i) {
      const double lon = first + (i + between(-0.28, 0.28)) * 360.0 / trains;
      const double lat = side * between(side > 0 ? 40.0 : 44.0, 63.0);
      add(lat, lon, side * between(3.5, 10.0), between(0.05, 0.095));
      if (i % 2 == 0)
        add(lat - side * between(8.0, 14.0), lon - between(14.0, 24.0), side * between(1.5, 3.5), between(0.035, 0.06));
      add(side * between(26.0, 37.0), lon + 180.0 / trains + between(-6.0, 6.0), -side * between(0.5, 1.1),
          between(0.14, 0.22));
    }
  }
  // Where the sea is warm: western Pacific, Atlantic and eastern Pacific, southern Indian Ocean and Coral Sea.
  const double basins[3][3] = {{1.0, 122.0, 168.0}, {1.0, -112.0, -48.0}, {-1.0, 52.0, 168.0}};
  for (const auto& [side, west, east] : basins)
    add(side * between(11.0, 21.0), between(west, east), side * between(9.0, 14.0), between(0.022, 0.034), true);
  while (count < shared::kWeatherVortices) add(90.0, 0.0, 0.0, 1.0);

  // Off California, Peru, Namibia, the Canaries, western Australia, and the summer's Aleutian stratus.
  const double decks[shared::kWeatherDecks][3] = {{27, -128, 0.17}, {-18, -84, 0.22}, {-14, 3, 0.20},
                                                  {24, -25, 0.12},  {-29, 104, 0.13}, {50, 178, 0.14}};
  for (uint32_t i = 0; i < shared::kWeatherDecks; ++i)
    g.decks[i] = glm::vec4(direction(decks[i][0] + between(-2.0, 2.0), decks[i][1] + between(-5.0, 5.0)),
                           static_cast<float>(decks[i][2] * between(0.85, 1.15)));
  g.size = size;
  g.seed = seed * 1000u;
  return g;
}

GeneratedWeather run_generator(gpu::Device& device, uint32_t size, uint32_t seed) {
  const gpu::ComputePipeline flow_pipeline(device, {.name = "weather.flow", .spirv = weather_flow_comp});
  const gpu::ComputePipeline trace_pipeline(device, {.name = "weather.trace", .spirv = weather_trace_comp});
  const gpu::ComputePipeline noise_pipeline(device, {.name = "weather.noise", .spirv = weather_noise_comp});
  const gpu::ComputePipeline generate_pipeline(device, {.name = "weather.generate", .spirv = weather_generate_comp});
  FrameGraph graph;
  const auto cube = [&](const char* name, uint32_t n) {
    return graph.create(name, {.extent = Extent2D{n, n}, .format = Format::rgba32f, .layers = 6, .cube = true});
  };
  const BufferRef parameters = graph.constants("weather.parameters", generator_parameters(size, seed));
  // Air has no finer structure than the flow that it came with, times what that draws out.
  const uint32_t trace_size = std::max(size / 2, 64u);
  const ImageRef flow = cube("weather.flow", kFlowSize), origin = cube("weather.origin", trace_size);
  const ImageRef recent = cube("weather.recent", trace_size), raw = cube("weather.raw", size);
  const ImageRef properties = cube("weather.raw_properties", size);
  const ImageRef noise = graph.create(
      "weather.noise", {.extent = Extent3D{kNoiseSize, kNoiseSize, kNoiseSize}, .format = Format::rgba16f});
  graph.pass("weather.noise").uniform("generate", parameters).write("out_noise", noise).record([&](gpu::Commands& cmd) {
    cmd.bind(noise_pipeline).dispatch_threads(kNoiseSize, kNoiseSize, kNoiseSize);
  });
  graph.pass("weather.flow").uniform("generate", parameters).write("out_flow", flow).record([&](gpu::Commands& cmd) {
    cmd.bind(flow_pipeline).dispatch_threads(kFlowSize, kFlowSize, 6);
  });
  graph.pass("weather.trace")
      .uniform("generate", parameters)
      .sample("flow_tex", flow)
      .write("out_origin", origin)
      .write("out_recent", recent)
      .record([&](gpu::Commands& cmd) { cmd.bind(trace_pipeline).dispatch_threads(trace_size, trace_size, 6); });
  graph.pass("weather.generate")
      .uniform("generate", parameters)
      .sample("origin_tex", origin)
      .sample("recent_tex", recent)
      .sample("noise_tex", noise, Sampler::linear_repeat)
      .write("out_weather", raw)
      .write("out_properties", properties)
      .record([&](gpu::Commands& cmd) { cmd.bind(generate_pipeline).dispatch_threads(size, size, 6); });
  graph.keep(raw);
  graph.keep(properties);
  gpu::GraphExecutor executor(device);
  executor.run(graph);

  const size_t texels = size_t{6} * size * size;
  GeneratedWeather weather{.size = size, .ranks = std::vector<uint16_t>(texels * 4), .properties = {}};
  const std::vector<float> face_weights = cube_texel_weights(size);
  std::vector<float> weights;
  for (int face = 0; face < 6; ++face) weights.insert(weights.end(), face_weights.begin(), face_weights.end());
  const std::vector<float> values = executor.read<float>(raw);
  for (uint32_t c = 0; c < 4; ++c) {
    const std::vector<uint16_t> ranks = area_ranks(values, 4, c, weights);
    for (size_t i = 0; i < texels; ++i) weather.ranks[i * 4 + c] = ranks[i];
  }
  for (const float v : executor.read<float>(properties)) weather.properties.push_back(glm::packHalf1x16(v));
  return weather;
}

}  // namespace

GeneratedWeather generate_weather(gpu::Device& device, uint32_t size, uint32_t seed) {
  const std::string name = "weather_" + std::to_string(size) + "_" + std::to_string(seed) + ".bin";
  const uint64_t key = kGeneratorVersion << 32 | seed;
  const size_t numbers = size_t{6} * size * size * 4;
  if (const auto cached = load_cached_blob(name, key); cached && cached->size() == 2 * numbers * sizeof(uint16_t)) {
    GeneratedWeather weather{size, std::vector<uint16_t>(numbers), std::vector<uint16_t>(numbers)};
    std::memcpy(weather.ranks.data(), cached->data(), numbers * sizeof(uint16_t));
    std::memcpy(weather.properties.data(), cached->data() + numbers * sizeof(uint16_t), numbers * sizeof(uint16_t));
    return weather;
  }
  GeneratedWeather weather = run_generator(device, size, seed);
  std::vector<std::byte> bytes(2 * numbers * sizeof(uint16_t));
  std::memcpy(bytes.data(), weather.ranks.data(), bytes.size() / 2);
  std::memcpy(bytes.data() + bytes.size() / 2, weather.properties.data(), bytes.size() / 2);
  store_cached_blob(name, key, bytes);
  return weather;
}

}  // namespace nepho
