#include <algorithm>
#include <cmath>
#include <cstring>

#include "rasters/gdal_opener.h"
#include "render/shared_data.h"
#include "weather/lonlat_grid.h"
#include "weather/weather_fixture.h"
#include "weather/weather_map.h"

namespace nepho {
namespace {

using namespace test;

constexpr LonLatBounds kGlobe{-180, -90, 180, 90};

/// A smooth field without special places: value 0.1..0.9, slope at most 2.5 per radian, curvature at most 16.
double smooth_field(double lat_deg, double lon_deg) {
  const double lat = rad_from_deg(lat_deg), lon = rad_from_deg(lon_deg);
  const dvec3 d{std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
  return 0.5 + 0.2 * std::sin(5.0 * d.x + 1.0) * std::cos(4.0 * d.y) + 0.2 * std::sin(6.0 * d.z + 3.0 * d.x + 0.5);
}

/// Places all over the sphere, and many near the poles and the antimeridian.
std::vector<LatLonDeg> places() {
  std::vector<LatLonDeg> all;
  for (int i = 0; i < 600; ++i)
    all.push_back({deg_from_rad(std::asin(1.0 - (i + 0.5) / 300.0)), std::fmod(i * 137.50776, 360.0) - 180.0});
  for (const double pole : {90.0, 89.9, 89.0, -89.0, -89.9, -90.0})
    for (double lon = -180.0; lon < 180.0; lon += 22.5) all.push_back({pole, lon});
  for (double lat = -88.0; lat < 90.0; lat += 4.0)
    for (const double off : {-0.7, -0.01, 0.0, 0.01, 0.7}) all.push_back({lat, 180.0 + off});
  return all;
}

CloudParams raster_params(int layers = 1) {
  CloudParams params;
  params.weather.source = "raster";
  params.layers.assign(static_cast<size_t>(layers), CloudLayer{});
  for (int i = 0; i < layers; ++i) params.layers[static_cast<size_t>(i)].weather_channel = std::string(1, "rgba"[i]);
  return params;
}

std::vector<glm::vec4> coverage_at(GpuFixture& gpu, const WeatherMap& map, const std::vector<LatLonDeg>& at) {
  std::vector<glm::vec4> directions;
  for (const LatLonDeg& p : at) directions.emplace_back(glm::vec3(map_direction(p.lat_deg, p.lon_deg)), 0.0f);
  return sample_cube(gpu, map.coverage(), directions);
}

TEST_CASE("gpu: a global raster comes back at every place, round the antimeridian and over the poles") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  struct Grid {
    uint32_t width, height;
    LonLatBounds bounds;
  };
  const std::vector<LatLonDeg> at = places();
  // -180..180; 0..360; rows centred on the poles; columns that no power of two divides.
  for (const Grid& g : {Grid{512, 256, kGlobe}, Grid{512, 256, {0, -90, 360, 90}},
                        Grid{480, 241, {-0.375, -90.375, 359.625, 90.375}}, Grid{1001, 501, kGlobe}}) {
    map.update(raster_params(), {.weather = make_field(g.width, g.height, g.bounds, smooth_field)});
    const std::vector<glm::vec4> v = coverage_at(gpu, map, at);
    double worst = 0.0;
    for (size_t i = 0; i < at.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(v[i].r) - smooth_field(at[i].lat_deg, at[i].lon_deg)));
    CAPTURE(g.width);
    // A tent of a texel (0.9 degrees at a face's centre) and the sampler's bilinear weights each smooth by
    // h^2 / 6 to h^2 / 8 of the curvature of both axes: 2 * 16 * (0.0156^2 / 6 + 0.0156^2 / 8) = 0.0023.
    CHECK(worst < 0.0023);
  }
}

TEST_CASE("gpu: near a pole a raster is averaged along its rows") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  // Columns of 0 and 1: what is left of them at 89.5 degrees is their mean.
  map.update(raster_params(), {.weather = make_field(720, 360, kGlobe, [](double, double lon) {
                                 return static_cast<int>(std::floor(lon * 2.0)) % 2 == 0 ? 1.0 : 0.0;
                               })});
  for (const glm::vec4& v : coverage_at(gpu, map, {{89.5, 10}, {-89.5, 100}, {90, 0}, {-90, 0}}))
    CHECK(std::abs(v.r - 0.5f) < 0.01f);
}

TEST_CASE("gpu: one band of total cover is split among the channels that layers draw from") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  const WeatherSources sources{.weather = make_field(64, 32, kGlobe, [](double, double) { return 0.64; })};
  for (const int layers : {1, 2, 4}) {
    map.update(raster_params(layers), sources);
    const glm::vec4 v = coverage_at(gpu, map, {{30, 40}})[0];
    for (int c = 0; c < 4; ++c) CHECK(std::abs(v[c] - (1.0 - std::pow(0.36, 1.0 / layers))) < 2.0 / 65535.0);
  }
  CloudParams params = raster_params(4);  // layers that are not drawn, or share a channel, take no share
  params.layers[1].thickness_m = 0.0;
  params.layers[2].density_scale = 0.0;
  params.layers[3].weather_channel = "r";
  map.update(params, sources);
  CHECK(std::abs(coverage_at(gpu, map, {{30, 40}})[0].r - 0.64f) < 2.0f / 65535.0f);
  // Four bands are four channels and are not split.
  map.update(raster_params(4), {.weather = make_field(
                                    64, 32, kGlobe, [](double, double) { return 0.64; }, 4)});
  CHECK(std::abs(coverage_at(gpu, map, {{30, 40}})[0].a - 0.64f) < 2.0f / 65535.0f);
}

TEST_CASE("gpu: holes are filled from around them; nothing but holes is an error") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  const auto holes = [](double lat, double lon) {
    const bool hole = std::hypot(lat - 20.0, lon - 30.0) < 12.0 || lat > 86.0 || std::abs(lon) > 177.0;
    return hole ? std::nan("") : 0.3 + 0.001 * lat;
  };
  map.update(raster_params(), {.weather = make_field(360, 180, kGlobe, holes)});
  const std::vector<LatLonDeg> at = {{20, 30}, {88, 100}, {90, 0}, {-40, 180}, {10, -178.5}};
  const std::vector<glm::vec4> v = coverage_at(gpu, map, at);
  for (size_t i = 0; i < at.size(); ++i)  // the fill is between the values around: 12 degrees of 0.001
    CHECK(std::abs(static_cast<double>(v[i].r) - (0.3 + 0.001 * at[i].lat_deg)) < 0.0125);
  const std::string message = message_of(
      [&] { map.update(raster_params(), {.weather = make_field(64, 32, kGlobe, [](double, double) { return NAN; })}); },
      ErrorKind::input);
  CHECK(message == "field.tif: holds no data, every pixel is void");
}

TEST_CASE("gpu: outside of a regional raster the sky is clear, with a soft edge, across the antimeridian too") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  map.update(raster_params(), {.weather = make_field(40, 20, {170, -10, 190, 10}, [](double, double) { return 0.8; })});
  const std::vector<glm::vec4> v =
      coverage_at(gpu, map, {{0, 180}, {5, -175}, {0, 175}, {0, 168.9}, {11.1, 180}, {0, 0}, {0, -10}, {-90, 0}});
  for (int i = 0; i < 3; ++i) CHECK(std::abs(v[static_cast<size_t>(i)].r - 0.8f) < 0.001f);
  for (size_t i = 3; i < v.size(); ++i) CHECK(v[i].r < 0.002f);
  // The edge: no step of more than a quarter within 0.1 degree.
  std::vector<LatLonDeg> line;
  for (double lon = 168.0; lon < 173.0; lon += 0.1) line.push_back({1.0, lon});
  const std::vector<glm::vec4> edge = coverage_at(gpu, map, line);
  for (size_t i = 1; i < edge.size(); ++i) {
    CHECK(edge[i].r - edge[i - 1].r < 0.25f);
    CHECK(edge[i].r >= edge[i - 1].r - 0.001f);
  }
}

TEST_CASE("a raster 20000 pixels wide is read at a reduction that keeps memory bounded") {
  /// Knows its pixels without storing them.
  struct Wide final : Raster {
    RasterInfo wide{.path = "wide.tif", .width = 20000, .height = 10000, .bands = 1, .bounds = kGlobe, .wraps = true};
    const RasterInfo& info() const override { return wide; }
    uint32_t reductions() const override { return 8; }
    Result<RasterBlock> read_block(uint32_t, uint32_t, uint32_t) const override { return RasterBlock{}; }
  };
  const Wide raster;
  CHECK(LonLatGrid::reduction_for(raster, 0.001) == 1);
  CHECK(LonLatGrid::reduction_for(raster, 0.08) == 2);
}

TEST_CASE("gpu: a tile keeps its channels, of any size, and its mips are means") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  RasterInfo info{.path = "tile.png", .width = 5, .height = 3, .bands = 4, .bounds = kGlobe, .wraps = true};
  std::vector<float> values;
  for (int i = 0; i < 15; ++i) values.insert(values.end(), {static_cast<float>(i) / 14.0f, 0.2f, 0.4f, 1.0f});
  CloudParams params;
  params.weather.source = "tile";
  map.update(params, {.tile = std::make_shared<ArrayRaster>(info, values)});
  CHECK(map.tile().desc().extent.width == 5);
  CHECK(map.tile().desc().extent.height == 3);
  REQUIRE(map.tile().desc().mip_levels == 3);
  const auto words_of = [&](uint32_t mip) {
    const std::vector<std::byte> bytes = gpu.device.download(map.tile(), mip);
    std::vector<uint16_t> words(bytes.size() / 2);
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return words;
  };
  const std::vector<uint16_t> texels = words_of(0);
  for (size_t i = 0; i < 15; ++i) {
    CHECK(std::abs(texels[i * 4] / 65535.0 - static_cast<double>(i) / 14.0) < 1e-5);
    CHECK(texels[i * 4 + 1] == 13107);
    CHECK(texels[i * 4 + 3] == 65535);
  }
  const std::vector<uint16_t> last = words_of(2);
  CHECK(std::abs(last[0] / 65535.0 - 0.5) < 0.005);
  CHECK(std::abs(last[2] / 65535.0 - 0.4) < 1e-4);
  CHECK(sample_cube(gpu, map.coverage(), {{0, 0, 1, 0}})[0] == glm::vec4(1.0f));
  // One band goes to all channels.
  map.update(params, {.tile = make_field(4, 4, kGlobe, [](double, double) { return 0.6; })});
  for (const uint16_t word : words_of(0)) CHECK(std::abs(word / 65535.0 - 0.6) < 1e-4);
}

TEST_CASE("gpu: the ground of a plateau in the sea; smooth slopes; msl is the geoid") {
  const CacheFolder cache;
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  const auto geoid = std::shared_ptr<const Geoid>(std::shared_ptr<void>{}, &Geoid::egm96());
  const auto plateau = make_field(720, 360, kGlobe, [](double lat, double lon) {
    return std::abs(lat - 35.0) < 15.0 && std::abs(lon - 90.0) < 20.0 ? 4500.0 : -4000.0;
  });
  CloudParams params;
  params.coverage = 0.5;
  params.layers[0].base_reference = "terrain";
  const WeatherSources sources{.elevation = {plateau}, .geoid = geoid};
  map.update(params, sources);
  const auto ground_at = [&](double lat, double lon, float lod = 0.0f) {
    return sample_cube(gpu, map.ground(), {{glm::vec3(map_direction(lat, lon)), lod}})[0];
  };
  const auto undulation = [&](double lat, double lon) {
    return static_cast<float>(geoid->undulation_m(rad_from_deg(lat), rad_from_deg(lon)));
  };
  // Texels of 40 km of a field whose steepest slopes are 0.3 m per km.
  CHECK(std::abs(ground_at(0, 80).r - undulation(0, 80)) < 3.0f);
  CHECK(std::abs(ground_at(90, 0).r - undulation(90, 0)) < 3.0f);
  CHECK(std::abs(ground_at(35, 90).g - (4500.0f + undulation(35, 90))) < 3.0f);
  CHECK(std::abs(ground_at(-30, -120).g - undulation(-30, -120)) < 3.0f);  // sea, not its bed
  for (double lat = 15.0; lat < 25.0; lat += 0.1) {
    const float rise = std::abs(ground_at(lat + 0.1, 90).g - ground_at(lat, 90).g);
    CHECK(rise < 4500.0f * 0.2f);  // never more than a fifth of a cliff within 11 km
    CHECK(ground_at(lat, 90).g > undulation(lat, 90) - 10.0f);
  }
  const WeatherMap::OffsetRange terrain = map.base_offset_range("terrain"), msl = map.base_offset_range("msl");
  CHECK((msl.low_m > -107.5 && msl.low_m < -100.0 && msl.high_m > 80.0 && msl.high_m < 86.0));
  CHECK(terrain.low_m == doctest::Approx(msl.low_m));
  CHECK((terrain.high_m > 4400.0 && terrain.high_m < 4600.0));
  // Nobody asks for it: nothing is made.
  params.layers[0].base_reference = "ellipsoid";
  map.update(params, sources);
  CHECK(map.ground().desc().extent.width == 1);
}

TEST_CASE("gpu: later elevation lies over earlier, and ellipsoidal heights get no geoid") {
  const CacheFolder cache;
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  const auto low = make_field(360, 180, kGlobe, [](double, double) { return 100.0; });
  RasterInfo info{.path = "high.tif", .width = 40, .height = 40, .bounds = {0, 40, 10, 50}};
  info.vertical = VerticalDatum::ellipsoid;
  const auto high = std::make_shared<ArrayRaster>(info, std::vector<float>(1600, 900.0f));
  CloudParams params;
  params.coverage = 0.5;
  params.layers[0].base_reference = "msl";
  map.update(params, {.elevation = {low, high}});
  const auto v =
      sample_cube(gpu, map.ground(), {{glm::vec3(map_direction(45, 5)), 0}, {glm::vec3(map_direction(20, 5)), 0}});
  CHECK(std::abs(v[0].g - 900.0f) < 0.1f);
  CHECK(std::abs(v[1].g - 100.0f) < 0.1f);
  CHECK(v[0].r == 0.0f);
}

TEST_CASE("gpu: a satellite picture keeps the mean that its rows weighted by area have") {
  GpuFixture gpu;
  const std::string file = shared_data("satellite/nasa_cloud_combined_2048.jpg");
  if (file.empty()) return;
  const std::shared_ptr<Raster> raster = make_gdal_opener()->open_weather(file);
  REQUIRE(raster->info().bands == 1);
  const uint32_t k = raster->reductions() - 1;
  const RasterBlock all = raster->read_block(k, 0, 0).take_or_throw(ErrorKind::input);
  double sum = 0.0, weight = 0.0;
  for (uint32_t y = 0; y < all.height; ++y) {
    // The map's own measure of area, in scaled space: d sin(beta), tan beta = b/a tan phi.
    const auto s = [&](double row) { return map_direction(90.0 - row * 180.0 / all.height, 0.0).z; };
    const double area = s(y) - s(y + 1);
    for (uint32_t x = 0; x < all.width; ++x) sum += area * static_cast<double>(all.values[size_t{y} * all.width + x]);
    weight += area * all.width;
  }
  WeatherMap map(gpu.device, 64);
  map.update(raster_params(), {.weather = raster});
  const uint32_t mips = map.coverage().desc().mip_levels;
  const std::vector<std::byte> last = gpu.device.download(map.coverage(), mips - 1);
  double mean = 0.0;
  for (size_t face = 0; face < 6; ++face)
    mean += reinterpret_cast<const uint16_t*>(last.data())[face * 4] / 65535.0 / 6.0;
  CHECK(std::abs(mean - sum / weight) < 0.002);
  CHECK((mean > 0.05 && mean < 0.7));
}

}  // namespace
}  // namespace nepho
