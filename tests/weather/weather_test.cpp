#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "base/blob_cache.h"
#include "io/file_test_tools.h"
#include "weather/coverage_statistics.h"
#include "weather/raster_weather.h"
#include "weather/weather_shared.h"

namespace nepho {
namespace {

TEST_CASE("exact_probit gives the quantiles of the standard normal (tables: 1.959964 at 0.975)") {
  CHECK(std::abs(exact_probit(0.5)) < 1e-9);
  CHECK(std::abs(exact_probit(0.975) - 1.959963985) < 1e-7);
  CHECK(std::abs(exact_probit(0.001) + 3.090232306) < 1e-6);
  CHECK(exact_probit(0.0) == -8.0);
  CHECK(exact_probit(1.0) == 8.0);
}

TEST_CASE("local coverage has the requested mean over the globe for every contrast") {
  for (const double contrast : {0.0, 0.3, 0.75, 0.9})
    for (const double coverage : {0.05, 0.4, 0.75}) {
      double sum = 0.0;
      constexpr int kRanks = 20000;
      for (int i = 0; i < kRanks; ++i) sum += local_coverage((i + 0.5) / kRanks, coverage, contrast);
      CHECK(std::abs(sum / kRanks - coverage) < 2e-4);
    }
}

TEST_CASE("no coverage is clear and full coverage is full everywhere") {
  for (const double rank : {0.0, 0.3, 1.0}) {
    CHECK(local_coverage(rank, 0.0, 0.9) == 0.0);
    CHECK(local_coverage(rank, 1.0, 0.9) == 1.0);
  }
}

TEST_CASE("area ranks are the share of the weight below a value, channel by channel") {
  std::mt19937 random(5);
  std::vector<float> values, weights;
  for (int i = 0; i < 5000; ++i) {
    values.push_back(static_cast<float>(random()) / 4294967296.0f);
    values.push_back(-std::log(static_cast<float>(random() | 1u) / 4294967296.0f));  // skewed, as rare weather is
    weights.push_back(i % 3 == 0 ? 3.0f : 1.0f);
  }
  for (uint32_t channel = 0; channel < 2; ++channel) {
    const std::vector<uint16_t> ranks = area_ranks(values, 2, channel, weights);
    double all = 0.0, worst = 0.0;
    for (const float w : weights) all += static_cast<double>(w);
    for (size_t i = 0; i < 5000; i += 97) {
      double below = 0.0;
      for (size_t k = 0; k < 5000; ++k)
        if (values[k * 2 + channel] < values[i * 2 + channel]) below += static_cast<double>(weights[k]);
      worst = std::max(worst, std::abs(ranks[i] / 65535.0 - below / all));
    }
    CHECK(worst < 3.0 * 3.0 / all + 1.0 / 65535.0);  // a bin holds a texel or two
  }
}

TEST_CASE("cover split among n independent layers leaves the same share clear") {
  for (const double total : {0.0, 0.2, 0.75, 1.0})
    for (const uint32_t n : {1u, 2u, 3u, 4u})
      CHECK(std::abs(1.0 - std::pow(1.0 - split_cover(total, n), n) - total) < 1e-12);
}

TEST_CASE("probit_from_share inverts share_from_probit, which is within 0.0095 of the normal distribution") {
  for (float z = -3.0f; z <= 3.0f; z += 0.25f) {
    const float share = shared::share_from_probit(z);
    CHECK(std::abs(shared::probit_from_share(share) - z) < 1e-4f);
    CHECK(std::abs(static_cast<double>(share) - 0.5 * std::erfc(-static_cast<double>(z) / std::sqrt(2.0))) < 0.0096);
  }
}

TEST_CASE("a cached blob comes back; another key, a flipped bit and a torn file give nothing") {
  const test::TempFolder folder;
  setenv("NEPHO_CACHE", folder.path().c_str(), 1);
  std::vector<std::byte> bytes(10007);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 31 >> 3);
  store_cached_blob("a.bin", 5, bytes);
  REQUIRE(load_cached_blob("a.bin", 5));
  CHECK(*load_cached_blob("a.bin", 5) == bytes);
  CHECK(!load_cached_blob("a.bin", 6));
  CHECK(!load_cached_blob("b.bin", 5));
  {
    std::fstream file(folder / "a.bin", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(4000);
    file.put('\x7f');
  }
  CHECK(!load_cached_blob("a.bin", 5));
  store_cached_blob("a.bin", 5, bytes);
  std::filesystem::resize_file(folder / "a.bin", 5000);
  CHECK(!load_cached_blob("a.bin", 5));
}

TEST_CASE("a cached blob is of one device; one that came with a packaged program serves all") {
  const test::TempFolder cache, data;
  setenv("NEPHO_CACHE", cache.path().c_str(), 1);
  const std::vector<std::byte> bytes(100, std::byte{3}), others(100, std::byte{4});
  store_cached_blob("a.bin", 5, bytes, 77);
  CHECK(load_cached_blob("a.bin", 5, 77));
  CHECK(!load_cached_blob("a.bin", 5, 78));
  std::filesystem::create_directory(data / "tables");
  std::filesystem::rename(cache / "a.bin", data / "tables" / "a.bin");
  CHECK(!load_cached_blob("a.bin", 5, 77));
  setenv("NEPHO_DATA", data.path().c_str(), 1);
  CHECK(load_cached_blob("a.bin", 5, 77));
  CHECK(load_cached_blob("a.bin", 5, 78));
  CHECK(!load_cached_blob("a.bin", 6, 77));
  store_cached_blob("a.bin", 5, others, 78);
  CHECK(*load_cached_blob("a.bin", 5, 78) == others);
  CHECK(*load_cached_blob("a.bin", 5, 77) == bytes);
  unsetenv("NEPHO_DATA");
}

}  // namespace
}  // namespace nepho
