#include "weather/weather_ground.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/blob_cache.h"
#include "weather/cube_field.h"
#include "weather/lonlat_grid.h"

namespace nepho {

namespace {

constexpr uint64_t kVersion = 1;
constexpr double kTexel_deg = 90.0 / WeatherGround::kSize;
/// Pixels this small are averaged, so that the land between seas keeps its height.
constexpr double kPixel_deg = 0.5 * kTexel_deg;
/// Half width of the tent: one and a half texels keep slopes gentle and the map free of steps.
constexpr double kHalfWidth_deg = 1.5 * kTexel_deg;

/// The file behind a raster's name: NETCDF:"file":VARIABLE and the like name theirs in quotes.
std::filesystem::path file_of(const std::string& name) {
  const size_t open = name.find('"'), close = name.rfind('"');
  return open != std::string::npos && close > open ? name.substr(open + 1, close - open - 1) : name;
}

/// Nothing when some raster is no file, so that nobody can tell whether it has changed.
std::optional<uint64_t> key_of(const std::vector<std::shared_ptr<Raster>>& elevation, const Geoid* geoid) {
  std::string text = fmt::format("{} {} {}", kVersion, WeatherGround::kSize, geoid && geoid->available());
  for (const auto& raster : elevation) {
    const RasterInfo& info = raster->info();
    std::error_code failed;
    const std::filesystem::path file = file_of(info.path);
    const auto bytes = std::filesystem::file_size(file, failed);
    if (failed) return std::nullopt;
    const auto written = std::filesystem::last_write_time(file, failed).time_since_epoch().count();
    text += fmt::format("|{} {} {} {} {} {} {} {} {} {}", info.path, info.width, info.height, info.bounds.west_deg,
                        info.bounds.south_deg, info.bounds.east_deg, info.bounds.north_deg,
                        static_cast<int>(info.vertical), bytes, written);
  }
  return checksum_of(reinterpret_cast<const std::byte*>(text.data()), text.size());
}

void add_raster(const Raster& raster, const std::vector<LatLonDeg>& places, std::vector<float>& texels) {
  const bool ellipsoidal = raster.info().vertical == VerticalDatum::ellipsoid;
  // Below the geoid is sea, before anything is averaged: shores do not sink towards the sea bed.
  const auto clip = [&](RasterBlock& block) {
    if (ellipsoidal) return;
    for (float& height_m : block.values) height_m = std::max(height_m, 0.0f);
  };
  const LonLatGrid grid(raster, LonLatGrid::reduction_for(raster, kPixel_deg), clip);
  constexpr size_t kChunk = 1024;
  parallel_for(places.size() / kChunk, [&](size_t chunk) {
    for (size_t i = chunk * kChunk; i < (chunk + 1) * kChunk; ++i) {
      float height_m = 0.0f;
      const double share = grid.sample(places[i].lat_deg, places[i].lon_deg, kHalfWidth_deg, &height_m);
      if (share <= 0.0) continue;
      const float geoid_m = texels[2 * i];
      const float ground_m = ellipsoidal ? std::max(height_m, geoid_m) : height_m + geoid_m;
      texels[2 * i + 1] += static_cast<float>(share) * (ground_m - texels[2 * i + 1]);
    }
  });
}

}  // namespace

WeatherGround make_weather_ground(const std::vector<std::shared_ptr<Raster>>& elevation, const Geoid* geoid) {
  constexpr uint32_t n = WeatherGround::kSize;
  WeatherGround ground;
  const std::optional<uint64_t> key = key_of(elevation, geoid);
  const std::string name = "weather_ground.bin";
  const auto cached = key ? load_cached_blob(name, *key) : std::nullopt;
  ground.texels.resize(size_t{6} * n * n * 2, 0.0f);
  if (cached && cached->size() == ground.texels.size() * sizeof(float)) {
    std::memcpy(ground.texels.data(), cached->data(), cached->size());
  } else {
    std::vector<LatLonDeg> places(size_t{6} * n * n);
    for (size_t i = 0; i < places.size(); ++i) {
      const auto x = static_cast<uint32_t>(i % n), y = static_cast<uint32_t>(i / n % n);
      places[i] = lat_lon_from_scaled(cube_texel_direction(n, static_cast<uint32_t>(i / (n * n)), x, y));
      if (geoid)
        ground.texels[2 * i] =
            static_cast<float>(geoid->undulation_m(rad_from_deg(places[i].lat_deg), rad_from_deg(places[i].lon_deg)));
    }
    for (const auto& raster : elevation) add_raster(*raster, places, ground.texels);
    std::vector<std::byte> bytes(ground.texels.size() * sizeof(float));
    std::memcpy(bytes.data(), ground.texels.data(), bytes.size());
    if (key) store_cached_blob(name, *key, bytes);
  }
  const auto range = [&](size_t channel, double& low, double& high) {
    low = high = static_cast<double>(ground.texels[channel]);
    for (size_t i = channel; i < ground.texels.size(); i += 2) {
      low = std::min(low, static_cast<double>(ground.texels[i]));
      high = std::max(high, static_cast<double>(ground.texels[i]));
    }
  };
  range(0, ground.lowest_geoid_m, ground.highest_geoid_m);
  range(1, ground.lowest_ground_m, ground.highest_ground_m);
  return ground;
}

}  // namespace nepho
