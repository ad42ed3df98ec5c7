#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

#include "weather/weather_fixture.h"
#include "weather/weather_map.h"

namespace nepho {
namespace {

using namespace test;

/// Means over the sphere of the channels of an rgba16 cube: its last mip's, as every mip is weighted by solid angle.
std::array<double, 4> means_of(GpuFixture& gpu, const gpu::Image& cube) {
  const uint32_t n = cube.desc().extent.width;
  const std::vector<std::byte> bytes = gpu.device.download(cube);
  const auto* texels = reinterpret_cast<const uint16_t*>(bytes.data());
  const std::vector<float> weights = cube_texel_weights(n);
  std::array<double, 4> sum{};
  for (size_t i = 0; i < size_t{6} * n * n; ++i)
    for (size_t c = 0; c < 4; ++c)
      sum[c] +=
          static_cast<double>(weights[i % (size_t{n} * n)]) * texels[i * 4 + c] / 65535.0 / (4.0 * std::numbers::pi);
  return sum;
}

/// Pairs of directions a hair apart on both sides of each of the 12 edges, the 8 corners and the 2 poles.
std::vector<std::array<dvec3, 2>> across_seams(double step) {
  std::vector<std::array<dvec3, 2>> pairs;
  const auto add = [&](const dvec3& seam, const dvec3& across) {
    pairs.push_back({glm::normalize(seam - step * across), glm::normalize(seam + step * across)});
  };
  for (int a = 0; a < 3; ++a)
    for (const double i : {-1.0, 1.0})
      for (const double j : {-1.0, 1.0}) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (double t = -0.97; t < 1.0; t += 0.055) {
          dvec3 seam{}, across{};
          seam[a] = t;
          seam[b] = i;
          seam[c] = j;
          across[b] = i;
          across[c] = -j;
          add(seam, across);
        }
        for (const double k : {-1.0, 1.0}) {  // each corner three times, each time along another edge's normal
          dvec3 corner{}, across{};
          corner[a] = k;
          corner[b] = i;
          corner[c] = j;
          across[b] = i;
          across[a] = -k;
          add(corner, across);
        }
      }
  for (const double z : {-1.0, 1.0})
    for (double turn = 0.0; turn < 3.0; turn += 0.4) add({0, 0, z}, {std::cos(turn), std::sin(turn), 0});
  return pairs;
}

CloudParams procedural(uint32_t seed) {
  CloudParams params;
  params.weather.seed = seed;
  return params;
}

TEST_CASE("gpu: each channel of procedural weather has its mean over the globe, and 0 and 1 are exact") {
  const CacheFolder cache;
  GpuFixture gpu;
  WeatherMap map(gpu.device, 128);
  CloudParams params = procedural(3);
  params.weather.mean_coverage_r = 0.4;
  params.weather.mean_coverage_g = 0.13;
  params.weather.mean_coverage_b = 0.77;
  params.weather.mean_coverage_a = 0.05;
  map.update(params, {});
  const std::array<double, 4> means = means_of(gpu, map.coverage());
  const double wanted[] = {0.4, 0.13, 0.77, 0.05};
  for (size_t c = 0; c < 4; ++c) CHECK(std::abs(means[c] - wanted[c]) < 0.001);
  // The last mip is the mean of a face.
  const std::vector<std::byte> last = gpu.device.download(map.coverage(), 7);
  REQUIRE(last.size() == 6 * 8);
  for (size_t c = 0; c < 4; ++c) {
    double mean = 0.0;
    for (size_t face = 0; face < 6; ++face)
      mean += reinterpret_cast<const uint16_t*>(last.data())[face * 4 + c] / 65535.0 / 6.0;
    CHECK(std::abs(mean - wanted[c]) < 0.001);
  }
  params.weather.mean_coverage_r = 0.0;
  params.weather.mean_coverage_g = 1.0;
  map.update(params, {});
  const std::vector<std::byte> bytes = gpu.device.download(map.coverage());
  const auto* texels = reinterpret_cast<const uint16_t*>(bytes.data());
  bool exact = true;
  for (size_t i = 0; i < bytes.size() / 8; ++i) exact = exact && texels[i * 4] == 0 && texels[i * 4 + 1] == 65535;
  CHECK(exact);
  // Properties keep their ranges.
  const std::vector<std::byte> raw = gpu.device.download(map.properties());
  std::array<float, 4> low{}, high{};
  low.fill(1e9f);
  high.fill(-1e9f);
  for (size_t i = 0; i < raw.size() / 2; ++i) {
    const float v = glm::unpackHalf1x16(reinterpret_cast<const uint16_t*>(raw.data())[i]);
    low[i % 4] = std::min(low[i % 4], v);
    high[i % 4] = std::max(high[i % 4], v);
  }
  CHECK((low[0] >= 0.0f && high[0] <= 1.0f && high[0] - low[0] > 0.8f));
  CHECK((low[1] >= -250.0f && high[1] <= 250.0f && high[1] - low[1] > 150.0f));
  CHECK((low[2] >= 0.699f && high[2] <= 1.401f && high[2] - low[2] > 0.2f));
  CHECK((low[3] == 0.0f && high[3] <= 1.0f && high[3] > 0.5f));
  const WeatherMap::OffsetRange range = map.base_offset_range("ellipsoid");
  CHECK(range.low_m == static_cast<double>(low[1]));
  CHECK(range.high_m == static_cast<double>(high[1]));
}

TEST_CASE("gpu: weather has no step across cube edges, corners and poles at any level of detail") {
  const CacheFolder cache;
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  map.update(procedural(5), {});
  constexpr double kStep = 1e-5;  // of a face's half: a seam would show whole, anything continuous hardly
  const auto pairs = across_seams(kStep);
  for (const double lod : {0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    std::vector<glm::vec4> at;
    for (const auto& pair : pairs)
      for (const dvec3& d : pair) at.emplace_back(glm::vec3(d), static_cast<float>(lod));
    float worst = 0.0f, most = 0.0f;
    for (const gpu::Image* cube : {&map.coverage(), &map.properties()}) {
      const std::vector<glm::vec4> v = sample_cube(gpu, *cube, at);
      for (size_t i = 0; i < v.size(); i += 2)
        for (int c = 0; c < 4; ++c) {
          const float scale = cube == &map.properties() && c == 1 ? 1.0f / 300.0f : 1.0f;
          worst = std::max(worst, scale * std::abs(v[i][c] - v[i + 1][c]));
          if (i >= 2) most = std::max(most, scale * std::abs(v[i][c] - v[i - 2][c]));
        }
    }
    CAPTURE(lod);
    CHECK(worst < 0.006f);  // 8 bits of filter weight on a full-scale step
    CHECK(most > 0.05f);    // there is weather to step over
  }
}

TEST_CASE("gpu: neighbouring texels across cube edges differ no more than those within faces") {
  const CacheFolder cache;
  GpuFixture gpu;
  constexpr int n = 128;
  WeatherMap map(gpu.device, n);
  map.update(procedural(7), {});
  const std::vector<std::byte> bytes = gpu.device.download(map.coverage());
  const auto* texels = reinterpret_cast<const uint16_t*>(bytes.data());
  for (size_t c = 0; c < 4; ++c) {
    const auto value = [&](uint32_t face, int x, int y) {
      return texels[((face * size_t{n} + static_cast<size_t>(y)) * n + static_cast<size_t>(x)) * 4 + c] / 65535.0;
    };
    /// The texel that holds a point of a face's plane, beyond its edge too.
    const auto value_at = [&](uint32_t face, double u, double v) {
      const CubePointD p = cube_from_direction(direction_from_cube(face, {u, v}));
      const auto index = [](double t) { return std::clamp(static_cast<int>(t * n), 0, n - 1); };
      return value(p.face, index(p.uv.x), index(p.uv.y));
    };
    std::vector<double> inside, across;
    for (uint32_t face = 0; face < 6; ++face)
      for (int i = 0; i < n; ++i)
        for (int k = 0; k + 1 < n; ++k) {
          if (i < 6 || i >= n - 6) {
            inside.push_back(std::abs(value(face, k, i) - value(face, k + 1, i)));
            inside.push_back(std::abs(value(face, i, k) - value(face, i, k + 1)));
          }
          if (k > 0) continue;
          const double t = (i + 0.5) / n, out = 0.5 / n;
          across.push_back(std::abs(value(face, 0, i) - value_at(face, -out, t)));
          across.push_back(std::abs(value(face, n - 1, i) - value_at(face, 1.0 + out, t)));
          across.push_back(std::abs(value(face, i, 0) - value_at(face, t, -out)));
          across.push_back(std::abs(value(face, i, n - 1) - value_at(face, t, 1.0 + out)));
        }
    std::sort(inside.begin(), inside.end());
    std::sort(across.begin(), across.end());
    const auto part = [](const std::vector<double>& v, double q) {
      return v[static_cast<size_t>(q * static_cast<double>(v.size() - 1))];
    };
    CAPTURE(c);
    // Steps across an edge go to the nearest texel, up to half a texel off along the edge: a little more.
    CHECK(part(across, 0.5) <= 1.25 * part(inside, 0.5) + 0.001);
    CHECK(part(across, 0.99) <= 1.25 * part(inside, 0.99));
    CHECK(part(across, 1.0) <= 1.5 * part(inside, 1.0));
    CHECK(part(inside, 0.99) > 0.02);  // there is weather
  }
}

TEST_CASE("gpu: the same seed gives the same weather, cached or not, another seed another") {
  const CacheFolder cache;
  GpuFixture gpu;
  WeatherMap a(gpu.device, 64), b(gpu.device, 64);
  a.update(procedural(1), {});
  b.update(procedural(1), {});  // from the cache
  CHECK(gpu.device.download(a.coverage()) == gpu.device.download(b.coverage()));
  CHECK(gpu.device.download(a.properties()) == gpu.device.download(b.properties()));
  b.update(procedural(2), {});
  CHECK(gpu.device.download(a.coverage()) != gpu.device.download(b.coverage()));
  CloudParams uniform = procedural(1);
  uniform.coverage = 0.5;
  b.update(uniform, {});
  b.update(procedural(1), {});
  CHECK(gpu.device.download(a.coverage()) == gpu.device.download(b.coverage()));
  CHECK(a.texel_m() == 2.0 * 6378137.0 / 64);
}

TEST_CASE("gpu: --coverage is that number in every channel, with neutral properties") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  for (const double coverage : {0.0, 0.4, 1.0}) {
    CloudParams params;
    params.coverage = coverage;
    map.update(params, {});
    const auto v = sample_cube(gpu, map.coverage(), {{1, 0, 0, 0}, {-0.3f, 0.4f, 0.9f, 3}});
    const auto p = sample_cube(gpu, map.properties(), {{1, 0, 0, 0}, {-0.3f, 0.4f, 0.9f, 3}});
    for (int i = 0; i < 2; ++i) {
      for (int c = 0; c < 4; ++c) CHECK(std::abs(v[i][c] - static_cast<float>(coverage)) < 1.0f / 65535.0f);
      CHECK(p[i] == glm::vec4(0.5f, 0.0f, 1.0f, 0.0f));
    }
    if (coverage != 0.4) CHECK(v[0].r == static_cast<float>(coverage));
    CHECK(map.texel_m() >= 1e9);
    CHECK(map.base_offset_range("msl").low_m == 0.0);
    CHECK(map.base_offset_range("terrain").high_m == 0.0);
  }
}

TEST_CASE("weather: a source that needs a file says so") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 64);
  for (const char* source : {"raster", "tile"}) {
    CloudParams params;
    params.weather.source = source;
    CHECK(message_of([&] { map.update(params, {}); }, ErrorKind::usage).find("needs a file") != std::string::npos);
  }
  // And leaves a map that the next parameters fill.
  const CacheFolder cache;
  map.update(procedural(7), {});
  CHECK(map.coverage().desc().extent.width == 64);
  CHECK(map.ground().desc().extent.width == 1);
}

}  // namespace
}  // namespace nepho
