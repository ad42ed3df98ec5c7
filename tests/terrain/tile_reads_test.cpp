#include "terrain/tile_reads.h"

#include <doctest/doctest.h>

#include "base/error.h"
#include "terrain/block_cache.h"
#include "test_rasters.h"

using namespace nepho;
using nepho::test::PlaneRaster;

namespace {

float first_value(const BlockCache& cache, uint32_t reduction) { return cache.block(reduction, 0, 0)->data.values[0]; }
bool any_data(const BlockCache& cache, uint32_t reduction) { return cache.block(reduction, 0, 0)->data.valid[0] != 0; }

}  // namespace

TEST_CASE("a draft reads what looks at few pixels, leaves out the rest, and keeps nothing of that") {
  const auto raster = std::make_shared<PlaneRaster>(16384, 16384);
  const BlockCache cache(raster, {.memory = nullptr, .disk = nullptr, .timeout_s = 0.0});
  {
    TileReads reads(TileReads::Extent::draft);
    CHECK(any_data(cache, 0));
    CHECK(any_data(cache, 3));
    CHECK(raster->reads == 2);
    CHECK(reads.left_out() == 0);
    for (const uint32_t reduction : {4u, 6u, 10u}) {
      CHECK_FALSE(any_data(cache, reduction));
      CHECK(cache.block(reduction, 0, 0)->failed);
    }
    CHECK(raster->reads == 2);
    CHECK(reads.left_out() == 6);
  }
  CHECK(first_value(cache, 6) == doctest::Approx(raster->mean(6, 0, 0)));
  CHECK(raster->reads == 1 + 64);  // at 8 x 8, of which one was there
  const TileReads reads(TileReads::Extent::draft);
  CHECK(first_value(cache, 6) == doctest::Approx(raster->mean(6, 0, 0)));  // now it costs nothing
  CHECK(reads.left_out() == 0);
}

TEST_CASE("a draft leaves nothing out of a raster with a pyramid, nor of a small one") {
  const auto large = std::make_shared<PlaneRaster>(16384, 16384), small = std::make_shared<PlaneRaster>(2000, 2000);
  large->has_pyramid = true;
  const BlockCache a(large), b(small);
  const TileReads reads(TileReads::Extent::draft);
  for (uint32_t reduction = 0; reduction < 10; ++reduction) {
    CHECK(any_data(a, reduction));
    CHECK(any_data(b, reduction));
  }
  CHECK(reads.left_out() == 0);
}

TEST_CASE("what a filter made of a draft is made again") {
  const auto ground = std::make_shared<PlaneRaster>(16384, 16384), picture = std::make_shared<PlaneRaster>(256, 256);
  const BlockCache below(ground);
  const BlockCache cache(picture, {}, [&](RasterBlock& block, uint32_t, uint32_t, uint32_t) {
    block.values[0] = any_data(below, 5) ? 1.0f : 0.0f;
  });
  {
    TileReads reads(TileReads::Extent::draft);
    CHECK(first_value(cache, 0) == 0.0f);
    CHECK(reads.left_out() == 1);
  }
  CHECK(first_value(cache, 0) == 1.0f);
  const TileReads reads(TileReads::Extent::draft);
  CHECK(first_value(cache, 0) == 1.0f);
}

TEST_CASE("without data nothing is read, and what is stopped throws and can be asked for again") {
  const auto raster = std::make_shared<PlaneRaster>(1024, 1024);
  const BlockCache cache(raster);
  {
    TileReads reads(TileReads::Extent::nothing);
    CHECK_FALSE(any_data(cache, 0));
    CHECK(reads.left_out() == 1);
  }
  CHECK(raster->reads == 0);
  std::atomic<bool> stop{false};
  {
    const TileReads reads(TileReads::Extent::everything, &stop);
    CHECK(any_data(cache, 0));
    stop = true;
    CHECK_THROWS_AS((void)cache.block(2, 0, 0), Error);
  }
  CHECK(TileReads::current() == nullptr);
  CHECK(first_value(cache, 2) == doctest::Approx(raster->mean(2, 0, 0)));
}
