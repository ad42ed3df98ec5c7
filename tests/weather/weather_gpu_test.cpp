#include <algorithm>
#include <cmath>

#include "gpu/gpu_fixture.h"
#include "weather/weather_map.h"
#include "weather/weather_shared.h"

namespace nepho {
namespace {

struct Faces {
  uint32_t size;
  std::vector<std::byte> texels;
  int at(uint32_t face, int x, int y) const {
    const size_t n = size;
    return static_cast<int>(texels[((face * n + static_cast<size_t>(y)) * n + static_cast<size_t>(x)) * 4]);
  }
  /// Nearest texel in a direction.
  int in_direction(const glm::vec3& d) const {
    uint32_t best = 0;
    for (uint32_t face = 1; face < 6; ++face)
      if (glm::dot(d, shared::cube_direction(face, 0, 0)) > glm::dot(d, shared::cube_direction(best, 0, 0)))
        best = face;
    const glm::vec3 axis = shared::cube_direction(best, 0, 0);
    const glm::vec3 p = d / glm::dot(d, axis) - axis;
    // u and v axes: derivatives of the unnormalised direction.
    const glm::vec3 u_axis = shared::cube_direction(best, 1, 0) * std::sqrt(2.0f) - axis;
    const glm::vec3 v_axis = shared::cube_direction(best, 0, 1) * std::sqrt(2.0f) - axis;
    const auto index = [&](float t) {
      return std::clamp(static_cast<int>((t * 0.5f + 0.5f) * static_cast<float>(size)), 0, static_cast<int>(size) - 1);
    };
    return at(best, index(glm::dot(p, u_axis)), index(glm::dot(p, v_axis)));
  }
};

TEST_CASE("gpu: the weather map has the coverage asked for and no step across cube edges") {
  GpuFixture gpu;
  WeatherMap map(gpu.device, 128);
  map.update({.coverage = 0.4, .contrast = 0.6, .seed = 3});
  const Faces faces{128, gpu.device.download(map.image())};
  const int n = 128;
  double sum = 0.0, weight = 0.0;
  std::vector<int> inside, across;
  for (uint32_t face = 0; face < 6; ++face)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double u = (x + 0.5) / n * 2.0 - 1.0, v = (y + 0.5) / n * 2.0 - 1.0;
        const double solid = std::pow(1.0 + u * u + v * v, -1.5);
        sum += solid * faces.at(face, x, y) / 255.0;
        weight += solid;
        if (x + 1 < n && (y < 4 || y >= n - 4))
          inside.push_back(std::abs(faces.at(face, x, y) - faces.at(face, x + 1, y)));
        if (y + 1 < n && (x < 4 || x >= n - 4))
          inside.push_back(std::abs(faces.at(face, x, y) - faces.at(face, x, y + 1)));
        for (const int side : {-1, 1}) {
          const auto fu = static_cast<float>(u), fv = static_cast<float>(v);
          const float out = static_cast<float>(side) * (1.0f + 1.0f / static_cast<float>(n));
          if (x == (side < 0 ? 0 : n - 1))
            across.push_back(
                std::abs(faces.at(face, x, y) - faces.in_direction(shared::cube_direction(face, out, fv))));
          if (y == (side < 0 ? 0 : n - 1))
            across.push_back(
                std::abs(faces.at(face, x, y) - faces.in_direction(shared::cube_direction(face, fu, out))));
        }
      }
  CHECK(std::abs(sum / weight - 0.4) < 0.005);  // 8 bits and 8192 bins
  std::sort(inside.begin(), inside.end());
  std::sort(across.begin(), across.end());
  const auto part = [](const std::vector<int>& v, double q) {
    return v[static_cast<size_t>(q * static_cast<double>(v.size() - 1))];
  };
  CHECK(part(across, 0.5) <= 1.15 * part(inside, 0.5) + 1.0);
  CHECK(part(across, 0.99) <= 1.15 * part(inside, 0.99) + 1.0);
  CHECK(part(across, 1.0) <= 1.5 * part(inside, 1.0));
  CHECK(part(inside, 0.5) >= 1);  // there is weather
}

TEST_CASE("gpu: the same seed gives the same map, another seed another") {
  GpuFixture gpu;
  WeatherMap a(gpu.device, 64), b(gpu.device, 64);
  a.update({.seed = 1});
  b.update({.seed = 1});
  CHECK(gpu.device.download(a.image()) == gpu.device.download(b.image()));
  b.update({.seed = 2});
  CHECK(gpu.device.download(a.image()) != gpu.device.download(b.image()));
  // The last mip is the mean of all, near the coverage.
  const std::vector<std::byte> last = gpu.device.download(a.image(), 6);
  double mean = 0.0;
  for (size_t face = 0; face < 6; ++face) mean += static_cast<double>(last[face * 4]) / 255.0 / 6.0;
  CHECK(std::abs(mean - 0.4) < 0.06);
}

}  // namespace
}  // namespace nepho
