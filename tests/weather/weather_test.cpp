#include "weather/weather_map.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "weather/blob_cache.h"
#include "weather/weather_shared.h"

namespace nepho {
namespace {

/// A cache folder of this test's own.
struct CacheFolder {
  CacheFolder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
    setenv("NEPHO_CACHE", path.c_str(), 1);
  }
  ~CacheFolder() { std::filesystem::remove_all(path); }
  std::filesystem::path path = std::filesystem::temp_directory_path() / "nepho_weather_test_cache";
};

TEST_CASE("exact_probit gives the quantiles of the standard normal (tables: 1.959964 at 0.975)") {
  CHECK(std::abs(exact_probit(0.5)) < 1e-9);
  CHECK(std::abs(exact_probit(0.975) - 1.959963985) < 1e-7);
  CHECK(std::abs(exact_probit(0.001) + 3.090232306) < 1e-6);
  CHECK(exact_probit(0.0) == -8.0);
  CHECK(exact_probit(1.0) == 8.0);
}

TEST_CASE("local coverage has the requested mean over the globe for every contrast") {
  for (const double contrast : {0.0, 0.3, 0.5, 0.9})
    for (const double coverage : {0.05, 0.4, 0.75}) {
      double sum = 0.0;
      constexpr int kRanks = 20000;
      for (int i = 0; i < kRanks; ++i)
        sum += local_coverage((i + 0.5) / kRanks, {.coverage = coverage, .contrast = contrast});
      CHECK(std::abs(sum / kRanks - coverage) < 2e-4);
    }
}

TEST_CASE("no coverage is clear and full coverage is full everywhere") {
  for (const double rank : {0.0, 0.3, 1.0}) {
    CHECK(local_coverage(rank, {.coverage = 0.0, .contrast = 0.9}) == 0.0);
    CHECK(local_coverage(rank, {.coverage = 1.0, .contrast = 0.9}) == 1.0);
  }
}

TEST_CASE("probit_from_share inverts share_from_probit, which is within 0.0095 of the normal distribution") {
  for (float z = -3.0f; z <= 3.0f; z += 0.25f) {
    const float share = shared::share_from_probit(z);
    CHECK(std::abs(shared::probit_from_share(share) - z) < 1e-4f);
    CHECK(std::abs(share - 0.5 * std::erfc(-z / std::sqrt(2.0))) < 0.0096);
  }
}

TEST_CASE("cube faces look along +-X +-Y +-Z and share their edges") {
  const glm::vec3 centres[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (uint32_t face = 0; face < 6; ++face) CHECK(shared::cube_direction(face, 0.0f, 0.0f) == centres[face]);
  // Vulkan's table: the right edge of +X is the left edge of -Z.
  for (float v = -1.0f; v <= 1.0f; v += 0.5f)
    CHECK(glm::length(shared::cube_direction(0, 1.0f, v) - shared::cube_direction(5, -1.0f, v)) < 1e-6f);
}

TEST_CASE("a cached blob comes back; another key, a flipped bit and a torn file give nothing") {
  CacheFolder folder;
  std::vector<std::byte> bytes(10007);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 31 >> 3);
  store_cached_blob("a.bin", 5, bytes);
  REQUIRE(load_cached_blob("a.bin", 5));
  CHECK(*load_cached_blob("a.bin", 5) == bytes);
  CHECK(!load_cached_blob("a.bin", 6));
  CHECK(!load_cached_blob("b.bin", 5));
  {
    std::fstream file(folder.path / "a.bin", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(4000);
    file.put('\x7f');
  }
  CHECK(!load_cached_blob("a.bin", 5));
  store_cached_blob("a.bin", 5, bytes);
  std::filesystem::resize_file(folder.path / "a.bin", 5000);
  CHECK(!load_cached_blob("a.bin", 5));
}

}  // namespace
}  // namespace nepho
