#include "weather/weather_map.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <optional>

#include "base/error.h"
#include "weather/coverage_statistics.h"
#include "weather/cube_field.h"
#include "weather/raster_weather.h"
#include "weather/weather_generator.h"
#include "weather/weather_ground.h"

namespace nepho {

namespace {

constexpr double kUniformTexel_m = 1e9;
constexpr std::array<float, 4> kNeutral = {0.5f, 0.0f, 1.0f, 0.0f};

bool is_drawn(const CloudLayer& layer) { return layer.thickness_m > 0.0 && layer.density_scale > 0.0; }

/// Distinct weather channels of the layers that are drawn, at least one.
uint32_t channels_used(const std::vector<CloudLayer>& layers) {
  std::string seen;
  for (const CloudLayer& layer : layers)
    if (is_drawn(layer) && seen.find(layer.weather_channel) == std::string::npos) seen += layer.weather_channel;
  return std::max<uint32_t>(1, static_cast<uint32_t>(seen.size()));
}

bool asks_for_ground(const std::vector<CloudLayer>& layers) {
  return std::any_of(layers.begin(), layers.end(),
                     [](const CloudLayer& layer) { return is_drawn(layer) && layer.base_reference != "ellipsoid"; });
}

/// Parameters that only say where the maps are looked up leave them as they are.
WeatherParams without_lookup(WeatherParams params) {
  const WeatherParams plain;
  params.drift_east_mps = plain.drift_east_mps;
  params.tile_period_m = plain.tile_period_m;
  params.tile_offset = plain.tile_offset;
  return params;
}

gpu::Image one_color_cube(gpu::Device& device, const char* name, Format format, std::vector<float> texel) {
  return make_cube_image(device, name, format, 1, [&](uint32_t) { return texel; });
}

}  // namespace

/// Equal contents mean equal images.
struct WeatherMap::Made {
  std::optional<double> coverage;
  WeatherParams weather;
  uint32_t channels = 1;
  bool ground = false;
  WeatherSources sources;
  std::optional<GeneratedWeather> generated;
  uint32_t generated_seed = 0;
};

WeatherMap::WeatherMap(gpu::Device& device, uint32_t procedural_size)
    : device_(device), procedural_size_(procedural_size) {
  tile_ = make_tile_image(device_, "weather.tile", Format::rgba16, 1, 1, {1.0f, 1.0f, 1.0f, 1.0f});
}

WeatherMap::~WeatherMap() = default;

WeatherMap::Refs WeatherMap::import_into(FrameGraph& graph) const {
  return {graph.import(coverage_), graph.import(properties_), graph.import(ground_), graph.import(tile_)};
}

WeatherMap::OffsetRange WeatherMap::base_offset_range(const std::string& base_reference) const {
  OffsetRange range = base_offset_;
  const OffsetRange reference = base_reference == "msl"       ? geoid_
                                : base_reference == "terrain" ? ground_range_
                                                              : OffsetRange{};
  return {range.low_m + reference.low_m, range.high_m + reference.high_m};
}

void WeatherMap::update(const CloudParams& params, const WeatherSources& sources) {
  const uint32_t channels = channels_used(params.layers);
  const bool ground = asks_for_ground(params.layers);
  if (!made_) made_ = std::make_unique<Made>();
  const bool first = !coverage_ || !ground_;  // the first time, or the first after one that threw
  const WeatherParams weather = without_lookup(params.weather);
  const bool from_raster = !params.coverage && params.weather.source == "raster";
  const bool from_tile = !params.coverage && params.weather.source == "tile";
  if (from_raster && !sources.weather)
    throw fail(ErrorKind::usage,
               "clouds.weather.source: raster needs a file; give clouds.weather.file or --weather FILE");
  if (from_tile && !sources.tile)
    throw fail(ErrorKind::usage, "clouds.weather.source: tile needs a file; give clouds.weather.file");

  const bool same_source = params.coverage == made_->coverage && (params.coverage || weather == made_->weather);
  const bool same_raster = !from_raster || (made_->sources.weather == sources.weather && made_->channels == channels);
  const bool same_tile = !from_tile || made_->sources.tile == sources.tile;
  const bool same_ground =
      made_->ground == ground &&
      (!ground || (made_->sources.elevation == sources.elevation && made_->sources.geoid == sources.geoid));
  if (first || !same_source || !same_raster || !same_tile) {
    if (params.coverage)
      make_uniform(*params.coverage);
    else if (from_raster)
      make_raster(*sources.weather, channels);
    else if (from_tile)
      make_tile(*sources.tile);
    else
      make_procedural(params.weather);
  }
  if (first || !same_ground) make_ground(sources, ground);
  made_->coverage = params.coverage;
  made_->weather = weather;
  made_->channels = channels;
  made_->ground = ground;
  made_->sources = sources;
}

void WeatherMap::make_neutral_properties() {
  properties_ = one_color_cube(device_, "weather.properties", Format::rgba16f, {kNeutral.begin(), kNeutral.end()});
  base_offset_ = {};
}

void WeatherMap::make_uniform(double coverage) {
  coverage_ =
      one_color_cube(device_, "weather.coverage", Format::rgba16, std::vector<float>(4, static_cast<float>(coverage)));
  make_neutral_properties();
  texel_m_ = kUniformTexel_m;
}

void WeatherMap::make_procedural(const WeatherParams& params) {
  if (!made_->generated || made_->generated_seed != params.seed) {
    made_->generated = generate_weather(device_, procedural_size_, params.seed);
    made_->generated_seed = params.seed;
  }
  const GeneratedWeather& weather = *made_->generated;
  const double means[4] = {params.mean_coverage_r, params.mean_coverage_g, params.mean_coverage_b,
                           params.mean_coverage_a};
  std::array<std::vector<float>, 4> coverage_of;  // by rank
  for (size_t c = 0; c < 4; ++c) {
    coverage_of[c].resize(65536);
    for (size_t r = 0; r < 65536; ++r) {
      // Ranks 0 and 1 would be the ends of the normal distribution.
      const double rank = std::clamp(static_cast<double>(r) / 65535.0, 0.5 / 65536.0, 1.0 - 0.5 / 65536.0);
      coverage_of[c][r] = static_cast<float>(local_coverage(rank, means[c], params.contrast));
    }
  }
  const size_t face_numbers = size_t{weather.size} * weather.size * 4;
  coverage_ = make_cube_image(device_, "weather.coverage", Format::rgba16, weather.size, [&](uint32_t face) {
    std::vector<float> out(face_numbers);
    for (size_t i = 0; i < face_numbers; ++i) out[i] = coverage_of[i % 4][weather.ranks[face * face_numbers + i]];
    return out;
  });
  base_offset_ = {1e9, -1e9};
  properties_ = make_cube_image(device_, "weather.properties", Format::rgba16f, weather.size, [&](uint32_t face) {
    std::vector<float> out(face_numbers);
    for (size_t i = 0; i < face_numbers; ++i) out[i] = glm::unpackHalf1x16(weather.properties[face * face_numbers + i]);
    for (size_t i = 1; i < face_numbers; i += 4) {
      base_offset_.low_m = std::min(base_offset_.low_m, static_cast<double>(out[i]));
      base_offset_.high_m = std::max(base_offset_.high_m, static_cast<double>(out[i]));
    }
    return out;
  });
  texel_m_ = 2.0 * Ellipsoid{}.a_m / weather.size;
}

void WeatherMap::make_raster(const Raster& raster, uint32_t channels) {
  const RasterWeather weather(raster);
  coverage_ = make_cube_image(device_, "weather.coverage", Format::rgba16, weather.size(),
                              [&](uint32_t face) { return weather.coverage(face, channels); });
  properties_ = make_cube_image(device_, "weather.properties", Format::rgba16f, weather.properties_size(),
                                [&](uint32_t face) { return weather.properties(face); });
  base_offset_ = {};
  texel_m_ = 2.0 * Ellipsoid{}.a_m / weather.size();
}

void WeatherMap::make_tile(const Raster& raster) {
  const RasterInfo& info = raster.info();
  std::vector<float> texels(size_t{info.width} * info.height * 4);
  constexpr uint32_t kSide = Raster::kBlockSize;
  for (uint32_t y0 = 0; y0 < info.height; y0 += kSide)
    for (uint32_t x0 = 0; x0 < info.width; x0 += kSide) {
      const RasterBlock block = raster.read_block(0, x0 / kSide, y0 / kSide).take_or_throw(ErrorKind::input);
      for (uint32_t y = 0; y < block.height; ++y)
        for (uint32_t x = 0; x < block.width; ++x)
          for (uint32_t c = 0; c < 4; ++c)
            texels[((size_t{y0} + y) * info.width + x0 + x) * 4 + c] =
                block.values[(size_t{y} * block.width + x) * info.bands + (info.bands == 4 ? c : 0)];
    }
  tile_ = make_tile_image(device_, "weather.tile", Format::rgba16, info.width, info.height, std::move(texels));
  make_uniform(1.0);
}

void WeatherMap::make_ground(const WeatherSources& sources, bool wanted) {
  geoid_ = ground_range_ = {};
  if (!wanted) {
    ground_ = one_color_cube(device_, "weather.ground", Format::rg32f, {0.0f, 0.0f});
    return;
  }
  const WeatherGround ground = make_weather_ground(sources.elevation, sources.geoid.get());
  constexpr size_t kFaceNumbers = size_t{WeatherGround::kSize} * WeatherGround::kSize * 2;
  ground_ = make_cube_image(device_, "weather.ground", Format::rg32f, WeatherGround::kSize, [&](uint32_t face) {
    const auto first = ground.texels.begin() + static_cast<std::ptrdiff_t>(face * kFaceNumbers);
    return std::vector<float>(first, first + static_cast<std::ptrdiff_t>(kFaceNumbers));
  });
  geoid_ = {ground.lowest_geoid_m, ground.highest_geoid_m};
  ground_range_ = {ground.lowest_ground_m, ground.highest_ground_m};
}

}  // namespace nepho
