#include "weather/weather_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "weather/blob_cache.h"
#include "weather/weather_generate.comp.h"
#include "weather/weather_shared.h"

namespace nepho {
namespace {

constexpr uint64_t kGeneratorVersion = 1;
static_assert(sizeof(shared::WeatherGenerate) == (shared::kWeatherVortices + 1) * 16 + 8);

/// Cyclones of the middle latitudes, both hemispheres, from the seed. North ones turn counter-clockwise.
shared::WeatherGenerate generator_parameters(uint32_t size, uint32_t seed) {
  shared::WeatherGenerate g{};
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (uint32_t i = 0; i < shared::kWeatherVortices; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double slot = static_cast<double>(i / 2) / (shared::kWeatherVortices / 2.0);
    const double lon = 2.0 * std::numbers::pi * (slot + 0.05 * uniform());
    const double lat = side * (40.0 + 24.0 * uniform()) * std::numbers::pi / 180.0;
    const double turn = side * (2.2 + 2.6 * uniform());
    g.vortices[i] = glm::vec4(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat), turn);
  }
  g.vortex_size = glm::vec4(0.11f, 0.003f, 0.0f, 0.0f);
  g.size = size;
  g.seed = seed * 1000u;
  return g;
}

double normal_share(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

}  // namespace

double exact_probit(double p) {
  if (p <= 1e-12) return -8.0;
  if (p >= 1.0 - 1e-12) return 8.0;
  constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                          1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02, 6.680131188771972e+01,
                          -1.328068155288572e+01};
  constexpr double c[] = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                          -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr double d[] = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00, 3.754408661907416e+00};
  if (p < 0.02425 || p > 1.0 - 0.02425) {
    const double q = std::sqrt(-2.0 * std::log(std::min(p, 1.0 - p)));
    const double x = (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
                     ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1.0);
    return p < 0.5 ? x : -x;
  }
  const double q = p - 0.5, r = q * q;
  return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
         (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1.0);
}

double local_coverage(double rank, const WeatherSettings& settings) {
  if (settings.coverage <= 0.0) return 0.0;
  if (settings.coverage >= 1.0) return 1.0;
  const double s = std::clamp(settings.contrast, 0.0, 0.95);
  return normal_share((exact_probit(settings.coverage) + s * exact_probit(rank)) / std::sqrt(1.0 - s * s));
}

WeatherMap::WeatherMap(gpu::Device& device, uint32_t size) : device_(device), size_(size) {
  image_ = device.create_image({.name = "weather.coverage",
                                .extent = {size, size},
                                .format = Format::rgba8,
                                .mip_levels = full_mip_levels({size, size}),
                                .layers = 6,
                                .cube = true});
}

double WeatherMap::texel_m() const { return 2.0 * 6378137.0 / size_; }

std::vector<uint16_t> WeatherMap::make_ranks(uint32_t seed) const {
  const std::string name = "weather_" + std::to_string(size_) + "_" + std::to_string(seed) + ".bin";
  const uint64_t key = kGeneratorVersion << 32 | seed;
  const size_t texels = size_t{6} * size_ * size_;
  std::vector<uint16_t> ranks(texels);
  if (const auto cached = load_cached_blob(name, key); cached && cached->size() == texels * sizeof(uint16_t)) {
    std::memcpy(ranks.data(), cached->data(), cached->size());
    return ranks;
  }

  const gpu::ComputePipeline pipeline(device_, {.name = "weather.generate", .spirv = weather_generate_comp});
  FrameGraph graph;
  const ImageRef raw = graph.create("weather.raw", {.extent = {size_, size_}, .format = Format::r32f, .layers = 6});
  const BufferRef parameters = graph.constants("weather.generate", generator_parameters(size_, seed));
  graph.pass("weather.generate")
      .uniform("generate", parameters)
      .write("out_weather", raw)
      .record([&](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(size_, size_, 6); });
  graph.keep(raw);
  gpu::GraphExecutor executor(device_);
  executor.run(graph);
  const std::vector<float> values = executor.read<float>(raw);

  // Ranks over the globe's area: a histogram weighted with the texels' solid angle, (1 + u^2 + v^2)^-3/2.
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double lowest = *low, range = std::max(1e-6, static_cast<double>(*high) - lowest);
  constexpr size_t kBins = 8192;
  std::vector<double> below(kBins + 1, 0.0);
  const auto bin_of = [&](float v) { return (static_cast<double>(v) - lowest) / range * (kBins - 1e-6); };
  for (size_t i = 0; i < texels; ++i) {
    const double u = (static_cast<double>(i % size_) + 0.5) / size_ * 2.0 - 1.0;
    const double v = (static_cast<double>(i / size_ % size_) + 0.5) / size_ * 2.0 - 1.0;
    const double r = 1.0 + u * u + v * v;
    below[static_cast<size_t>(bin_of(values[i])) + 1] += 1.0 / (r * std::sqrt(r));
  }
  for (size_t i = 0; i < kBins; ++i) below[i + 1] += below[i];
  for (size_t i = 0; i < texels; ++i) {
    const double at = bin_of(values[i]);
    const size_t bin = static_cast<size_t>(at);
    const double share = (below[bin] + (at - static_cast<double>(bin)) * (below[bin + 1] - below[bin])) / below[kBins];
    ranks[i] = static_cast<uint16_t>(std::clamp(share, 0.0, 1.0) * 65535.0 + 0.5);
  }
  std::vector<std::byte> bytes(texels * sizeof(uint16_t));
  std::memcpy(bytes.data(), ranks.data(), bytes.size());
  store_cached_blob(name, key, bytes);
  return ranks;
}

void WeatherMap::update(const WeatherSettings& settings) {
  if (made_ && settings == settings_) return;
  if (!made_ || settings.seed != settings_.seed) ranks_ = make_ranks(settings.seed);
  settings_ = settings;
  made_ = true;

  std::vector<float> coverage_of(4097);  // by rank; smooth enough for linear steps
  for (size_t i = 0; i <= 4096; ++i)
    coverage_of[i] =
        static_cast<float>(local_coverage(std::clamp(static_cast<double>(i) / 4096.0, 1e-4, 1.0 - 1e-4), settings));
  std::vector<float> level(ranks_.size());
  for (size_t i = 0; i < level.size(); ++i) {
    const float at = static_cast<float>(ranks_[i]) * (4096.0f / 65535.0f);
    const size_t k = std::min<size_t>(static_cast<size_t>(at), 4095);
    level[i] = coverage_of[k] + (at - static_cast<float>(k)) * (coverage_of[k + 1] - coverage_of[k]);
  }

  const uint32_t mips = full_mip_levels({size_, size_});
  std::vector<std::vector<std::byte>> texels(mips * 6);
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t mip = 0, n = size_; mip < mips; ++mip, n = std::max(n / 2, 1u)) {
    for (uint32_t face = 0; face < 6; ++face) {
      std::vector<std::byte>& bytes = texels[mip * 6 + face];
      bytes.resize(size_t{n} * n * 4);
      for (size_t i = 0; i < size_t{n} * n; ++i) {
        const auto value = static_cast<std::byte>(static_cast<int>(level[face * size_t{n} * n + i] * 255.0f + 0.5f));
        std::fill_n(&bytes[i * 4], 4, value);
      }
      uploads.push_back({.image = &image_, .bytes = bytes, .mip = mip, .layer = face});
    }
    const uint32_t half = std::max(n / 2, 1u);
    std::vector<float> next(size_t{6} * half * half);
    for (size_t i = 0; i < next.size(); ++i) {
      const size_t face = i / (size_t{half} * half), y = i / half % half, x = i % half;
      const float* from = &level[face * n * n];
      const size_t x0 = 2 * x, x1 = std::min<size_t>(x0 + 1, n - 1), y0 = 2 * y, y1 = std::min<size_t>(y0 + 1, n - 1);
      next[i] = 0.25f * (from[y0 * n + x0] + from[y0 * n + x1] + from[y1 * n + x0] + from[y1 * n + x1]);
    }
    level = std::move(next);
  }
  device_.upload(uploads);
}

}  // namespace nepho
