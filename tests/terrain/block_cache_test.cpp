#include "terrain/block_cache.h"

#include <doctest/doctest.h>

#include <condition_variable>
#include <limits>
#include <set>
#include <thread>

#include "terrain/height_sampler.h"
#include "test_rasters.h"

using namespace nepho;
using nepho::test::PlaneRaster;
using nepho::test::sleep_s;

namespace {

constexpr uint64_t kBlockBytes = 256 * 256 * 5;

RasterCaches impatient(double timeout_s) { return {.memory = nullptr, .disk = nullptr, .timeout_s = timeout_s}; }

bool no_data(const BlockCache::Block& block) {
  return std::all_of(block.data.valid.begin(), block.data.valid.end(), [](uint8_t v) { return v == 0; });
}

/// The largest difference of a block's pixels from the plane's means.
double error_of(const PlaneRaster& raster, const BlockCache::Block& block, uint32_t reduction, uint32_t bx, uint32_t by,
                uint32_t side) {
  double worst = 0.0;
  for (uint32_t y = 0; y < block.data.height; ++y)
    for (uint32_t x = 0; x < block.data.width; ++x) {
      const size_t p = size_t{y} * block.data.width + x;
      if (!block.data.valid[p]) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, std::abs(static_cast<double>(block.data.values[p]) -
                                       raster.mean(reduction, bx * side + x, by * side + y)));
    }
  return worst;
}

}  // namespace

TEST_CASE("caches of one budget hold no more than it together, and drop what was asked for longest ago") {
  const auto budget = std::make_shared<HostBudget>(20 * kBlockBytes);
  const auto one = std::make_shared<PlaneRaster>(256 * 16, 256), two = std::make_shared<PlaneRaster>(256 * 16, 256);
  const BlockCache a(one, {.memory = budget, .disk = nullptr}), b(two, {.memory = budget, .disk = nullptr});
  for (uint32_t i = 0; i < 16; ++i) a.block(0, i, 0);
  CHECK(one->reads == 16);
  CHECK(budget->bytes() > 16 * kBlockBytes);
  const auto held = a.block(0, 3, 0);  // used again: younger than all the others
  for (uint32_t i = 0; i < 10; ++i) b.block(0, i, 0);
  CHECK(budget->bytes() <= budget->limit_bytes());
  CHECK(budget->peak_bytes() <= budget->limit_bytes());
  CHECK(budget->dropped() >= 6);
  a.block(0, 3, 0);
  a.block(0, 15, 0);
  CHECK(one->reads == 16);  // the young ones are still there
  a.block(0, 0, 0);
  CHECK(one->reads == 17);  // the oldest had to go
  for (uint32_t i = 0; i < 16; ++i) b.block(0, i, 0);
  for (uint32_t i = 0; i < 4; ++i) b.block(0, i, 0);
  CHECK(held->data.values[0] == 3 * 256 * 2 + 1.0f);  // in use: alive wherever it was dropped from
}

TEST_CASE("a cache that goes gives its bytes back") {
  const auto budget = std::make_shared<HostBudget>(100 * kBlockBytes);
  {
    const BlockCache cache(std::make_shared<PlaneRaster>(1024, 1024), {.memory = budget, .disk = nullptr});
    for (uint32_t k = 0; k < 10; ++k) cache.block(k, 0, 0);
    CHECK(budget->bytes() > 0);
  }
  CHECK(budget->bytes() == 0);
}

TEST_CASE("a value larger than the whole budget is handed out, and is not kept in its way") {
  const auto budget = std::make_shared<HostBudget>(kBlockBytes / 2);
  const BlockCache cache(std::make_shared<PlaneRaster>(512, 512), {.memory = budget, .disk = nullptr});
  for (int round = 0; round < 3; ++round)
    for (uint32_t i = 0; i < 4; ++i) CHECK(cache.block(0, i % 2, i / 2)->all_valid);
  CHECK(budget->bytes() <= 2 * kBlockBytes);
}

TEST_CASE("a block that several threads ask for together is read once") {
  const auto raster = std::make_shared<PlaneRaster>(1024, 1024);
  raster->before = [](uint32_t, uint32_t, uint32_t, uint64_t) {
    sleep_s(0.01);
    return true;
  };
  const BlockCache cache(raster, impatient(30.0));
  std::vector<std::thread> threads;
  std::atomic<uint32_t> wrong{0};
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&] {
      for (uint32_t i = 0; i < 16; ++i)
        if (error_of(*raster, *cache.block(0, i % 4, i / 4), 0, i % 4, i / 4, 256) > 0.0) ++wrong;
    });
  for (std::thread& t : threads) t.join();
  CHECK(wrong == 0);
  CHECK(raster->reads == 16);
}

TEST_CASE("threads that use two caches of a tight budget get the right blocks and stay within it") {
  const auto budget = std::make_shared<HostBudget>(9 * kBlockBytes);
  const auto raster = std::make_shared<PlaneRaster>(2048, 1024);
  const BlockCache a(raster, {.memory = budget, .disk = nullptr}), b(raster, {.memory = budget, .disk = nullptr});
  std::vector<std::thread> threads;
  std::atomic<uint32_t> wrong{0};
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      uint32_t state = t + 1;
      for (int i = 0; i < 200; ++i) {
        state = state * 1664525u + 1013904223u;
        const uint32_t k = (state >> 8) % 3, bx = (state >> 16) % 8, by = (state >> 20) % 4;
        const BlockCache& cache = state >> 31 ? a : b;
        if (error_of(*raster, *cache.block(k, bx, by), k, bx, by, 256 >> k) > 1e-3) ++wrong;
      }
    });
  for (std::thread& t : threads) t.join();
  CHECK(wrong == 0);
  CHECK(budget->bytes() <= budget->limit_bytes());
  CHECK(budget->dropped() > 0);
}

TEST_CASE("reductions of a small raster are means of its pixels, made from the blocks there alone") {
  const auto raster = std::make_shared<PlaneRaster>(1000, 700);
  const BlockCache cache(raster);
  for (uint32_t k = 1; k <= 8; ++k) CHECK(error_of(*raster, *cache.block(k, 0, 0), k, 0, 0, cache.side_at(k)) < 1e-3);
  CHECK(raster->reads == 1);
  // At the rims pixels of the edges are averaged with those there are: weights of halves are off by under a pixel.
  CHECK(error_of(*raster, *cache.block(10, 0, 0), 10, 0, 0, 256) < 1000.0);
  CHECK(raster->reads == 12);
}

TEST_CASE("a large raster without a pyramid is looked at once for all coarse reductions together") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
  const BlockCache cache(raster);
  CHECK(cache.whole_is_dear());
  CHECK(error_of(*raster, *cache.block(6, 0, 0), 6, 0, 0, 256) < 0.01);
  CHECK(raster->reads == 32);  // 2048 x 2048 pixels each
  cache.block(5, 1, 0);
  cache.block(7, 0, 0);
  CHECK(raster->reads == 32);
  cache.block(2, 0, 0);
  CHECK(raster->reads == 33);
}

TEST_CASE("a large raster with a pyramid is read at the reduction asked for") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
  raster->has_pyramid = true;
  const BlockCache cache(raster);
  CHECK_FALSE(cache.whole_is_dear());
  CHECK(error_of(*raster, *cache.block(6, 0, 0), 6, 0, 0, 256) == 0.0);
  CHECK(raster->reads == 1);
}

TEST_CASE("the range of heights of a large raster without a pyramid is not worth reading all of it") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
  const HeightSampler heights({raster}, false, nullptr);
  CHECK(raster->reads <= 16);
  CHECK(heights.highest_land_m() > 8848.0);
  CHECK(heights.deepest_land_m() > 430.0);
}

TEST_CASE("blocks that fail count as no data, the others are there") {
  const auto raster = std::make_shared<PlaneRaster>(1024, 1024);
  raster->before = [](uint32_t, uint32_t bx, uint32_t by, uint64_t) { return (bx + by) % 2 == 0; };
  const BlockCache cache(raster, impatient(30.0));
  for (uint32_t i = 0; i < 16; ++i) {
    const auto block = cache.block(0, i % 4, i / 4);
    const bool good = (i % 4 + i / 4) % 2 == 0;
    CHECK(block->failed != good);
    CHECK(block->all_valid == good);
    CHECK(no_data(*block) != good);
  }
  const auto whole = cache.block(2, 0, 0);
  CHECK(whole->all_valid);
  // A pixel of the last reduction lies half over blocks that failed: it is the mean of what could be read.
  CHECK_FALSE(no_data(*cache.block(10, 0, 0)));
  const SourceStats stats = cache.stats();
  CHECK(stats.failed == 8);
  CHECK(stats.retried > 0);
  CHECK_FALSE(stats.given_up);
  CHECK(stats.failure == "plane: broken");
}

TEST_CASE("a read that fails at first is tried again") {
  const auto raster = std::make_shared<PlaneRaster>(256, 256);
  raster->before = [](uint32_t, uint32_t, uint32_t, uint64_t number) { return number > 2; };
  const BlockCache cache(raster);
  CHECK(error_of(*raster, *cache.block(0, 0, 0), 0, 0, 0, 256) == 0.0);
  CHECK(cache.stats().retried == 2);
  CHECK(cache.stats().failed == 0);
  CHECK(cache.stats().failure.empty());
}

TEST_CASE("what a raster throws, and blocks of a wrong size, are failures like others") {
  const auto raster = std::make_shared<PlaneRaster>(512, 256);
  raster->before = [](uint32_t, uint32_t bx, uint32_t, uint64_t) -> bool {
    if (bx == 0) throw std::runtime_error("no way");
    return true;
  };
  const BlockCache cache(raster, impatient(30.0));
  CHECK(no_data(*cache.block(0, 0, 0)));
  CHECK(cache.block(0, 1, 0)->all_valid);
  CHECK(cache.stats().failure == "plane: no way");

  class Liar final : public Raster {
   public:
    Liar() {
      info_.path = "liar";
      info_.width = info_.height = 300;
    }
    const RasterInfo& info() const override { return info_; }
    uint32_t reductions() const override { return 2; }
    Result<RasterBlock> read_block(uint32_t, uint32_t, uint32_t) const override {
      return RasterBlock{.width = 256, .height = 256, .values = std::vector<float>(7), .valid = {}};
    }
    RasterInfo info_;
  };
  const BlockCache lies(std::make_shared<Liar>());
  CHECK(lies.block(0, 1, 1)->data.valid.size() == 44 * 44);
  CHECK(lies.stats().failure == "liar: delivers blocks of another size than it should");
}

TEST_CASE("a large block that cannot be read as a whole shows what can be read of it") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
  // As a file that was cut off: whatever touches its last quarter fails.
  raster->before = [](uint32_t k, uint32_t, uint32_t by, uint64_t) { return ((by + 1) * 256u << k) <= 6144u; };
  const BlockCache cache(raster, impatient(30.0));
  const auto block = cache.block(6, 0, 0);
  CHECK(block->failed);
  REQUIRE(block->data.height == 128);
  for (uint32_t y = 0; y < 128; ++y) CHECK(block->data.valid[y * 256] == (y < 96 ? 1 : 0));
  CHECK(static_cast<double>(block->data.values[95 * 256]) == doctest::Approx(raster->mean(6, 0, 95)));
}

TEST_CASE("where a fine block fails a coarser level of the source shows") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
  raster->has_pyramid = true;
  raster->before = [](uint32_t k, uint32_t, uint32_t, uint64_t) { return k >= 4; };
  const BlockCache cache(raster, impatient(30.0));
  const auto block = cache.block(0, 5, 7);
  CHECK(block->failed);
  CHECK(block->all_valid);
  for (uint32_t i = 0; i < 256; i += 5) {
    const double truth = raster->mean(0, 5 * 256 + i, 7 * 256 + i);
    // Half of the coarse pixel's side along each axis.
    CHECK(std::abs(static_cast<double>(block->data.values[i * 257]) - truth) <= 8.0 * 5.0);
  }
}

TEST_CASE("a source that hangs is given up, and others are not held up by it") {
  std::mutex mutex;
  std::condition_variable changed;
  bool release = false;
  const auto raster = std::make_shared<PlaneRaster>(1024, 1024, "hangs");
  raster->before = [&](uint32_t, uint32_t bx, uint32_t, uint64_t) {
    std::unique_lock lock(mutex);
    if (bx == 1) changed.wait(lock, [&] { return release; });
    return true;
  };
  const BlockCache cache(raster, impatient(1.0));
  CHECK(cache.block(0, 0, 0)->all_valid);
  const auto other = std::make_shared<PlaneRaster>(1024, 1024);
  const BlockCache healthy(other, impatient(30.0));
  std::thread waits([&] { CHECK(no_data(*cache.block(0, 1, 0))); });
  CHECK(healthy.block(0, 0, 0)->all_valid);
  waits.join();
  CHECK(calls_left_behind());
  CHECK(cache.stats().given_up);
  CHECK(cache.stats().failure == "hangs: does not answer within 1 s");
  const uint64_t reads = raster->reads;
  CHECK(no_data(*cache.block(0, 2, 2)));
  CHECK(cache.block(0, 0, 0)->all_valid);  // what was read is still there
  CHECK(raster->reads == reads);
  {
    const std::lock_guard lock(mutex);
    release = true;
  }
  changed.notify_all();
  while (calls_left_behind()) sleep_s(0.01);  // it holds references to this function's variables
}

TEST_CASE("a read that computes for longer than the timeout is waited for") {
  const auto raster = std::make_shared<PlaneRaster>(256, 256);
  raster->before = [](uint32_t, uint32_t, uint32_t, uint64_t) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(2500)) {
    }
    return true;
  };
  const BlockCache cache(raster, impatient(1.0));
  CHECK(cache.block(0, 0, 0)->all_valid);
  CHECK_FALSE(cache.stats().given_up);
}

TEST_CASE("a source with nothing but slow errors is given up when they took longer than the timeout") {
  const auto raster = std::make_shared<PlaneRaster>(256 * 64, 256);
  raster->before = [](uint32_t, uint32_t, uint32_t, uint64_t) {
    sleep_s(0.05);
    return false;
  };
  const BlockCache cache(raster, impatient(1.0));
  for (uint32_t i = 0; i < 64; ++i) CHECK(no_data(*cache.block(0, i, 0)));
  CHECK(cache.stats().given_up);
  CHECK(raster->reads < 40);
}

TEST_CASE("a source of errors now and then is not given up") {
  const auto raster = std::make_shared<PlaneRaster>(256 * 24, 256);
  raster->before = [](uint32_t, uint32_t bx, uint32_t, uint64_t) {
    sleep_s(0.05);
    return bx % 2 == 1;
  };
  const BlockCache cache(raster, impatient(1.5));
  for (uint32_t i = 0; i < 24; ++i) CHECK(no_data(*cache.block(0, i, 0)) == (i % 2 == 0));
  CHECK_FALSE(cache.stats().given_up);  // although all its errors together took longer than that
}
