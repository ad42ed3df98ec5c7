#include "terrain/baked_raster.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "io/array_raster.h"
#include "io/file_test_tools.h"

using namespace nepho;
using nepho::test::TempFolder;

namespace {

/// Hills, or colours, of 16 bits; a hole in the first block.
std::shared_ptr<Raster> example(uint32_t width, uint32_t height, uint32_t bands) {
  RasterInfo info;
  info.path = "example";
  info.width = width;
  info.height = height;
  info.bands = bands;
  info.bounds = {-180.04, -90.04, 179.96, 90.04};
  info.wraps = true;
  info.vertical = VerticalDatum::ellipsoid;
  info.oversampling = 2.0;
  info.opacity = 0.5;
  std::vector<float> values(size_t{width} * height * bands);
  std::vector<uint8_t> valid(size_t{width} * height, 1);
  for (size_t i = 0; i < values.size(); ++i)
    values[i] = bands == 1 ? std::floor(9000.0f * std::sin(static_cast<float>(i) * 0.01f)) - 500.0f
                           : static_cast<float>(i * i / 7 % 256);
  if (bands == 1) values[1] = -32768.0f, values[2] = 32767.0f;
  valid[width + 5] = 0;
  for (uint32_t b = 0; b < bands; ++b) values[(width + 5) * bands + b] = 0.0f;
  return std::make_shared<ArrayRaster>(info, std::move(values), std::move(valid));
}

}  // namespace

TEST_CASE("a baked raster gives the very numbers of what it was made of, at every reduction") {
  const TempFolder folder;
  for (const uint32_t bands : {1u, 4u}) {
    const auto raster = example(700, 300, bands);
    bake_raster(*raster, folder / "a.baked");
    const auto baked = open_baked_raster(folder / "a.baked");
    const RasterInfo &a = raster->info(), &b = baked->info();
    CHECK(b.path == (folder / "a.baked").string());
    CHECK(b.width == a.width);
    CHECK(b.height == a.height);
    CHECK(b.bands == bands);
    CHECK(b.bounds.west_deg == a.bounds.west_deg);
    CHECK(b.bounds.north_deg == a.bounds.north_deg);
    CHECK(b.wraps);
    CHECK(b.vertical == VerticalDatum::ellipsoid);
    CHECK(b.oversampling == 2.0);
    CHECK(b.opacity == 0.5);
    CHECK_FALSE(b.fingerprint.empty());
    REQUIRE(baked->reductions() == raster->reductions());
    for (uint32_t k = 0; k < raster->reductions(); ++k)
      for (uint32_t by = 0; (by << (8 + k)) < a.height; ++by)
        for (uint32_t bx = 0; (bx << (8 + k)) < a.width; ++bx) {
          const auto expected = raster->read_block(k, bx, by), found = baked->read_block(k, bx, by);
          REQUIRE(found);
          CHECK(found->width == expected->width);
          CHECK(found->height == expected->height);
          CHECK(found->valid == expected->valid);
          CHECK(found->values == expected->values);
        }
    CHECK_FALSE(baked->read_block(0, 3, 0));
  }
}

TEST_CASE("a baked raster that is cut off, damaged, missing or something else is refused with its name") {
  const TempFolder folder;
  const std::filesystem::path file = folder / "a.baked";
  bake_raster(*example(300, 20, 1), file);
  const std::string good = test::bytes_of(file);
  const auto refused = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    try {
      open_baked_raster(file);
    } catch (const Error& e) {
      return e.kind() == ErrorKind::input && std::string(e.what()).starts_with(file.string());
    }
    return false;
  };
  for (const size_t size : {size_t{0}, size_t{87}, size_t{100}, good.size() - 1}) CHECK(refused(good.substr(0, size)));
  CHECK(refused(good + "x"));
  for (const size_t at : {size_t{3}, size_t{9}, size_t{20}, size_t{95}, good.size() / 2, good.size() - 1}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 4);
    CHECK(refused(bad));
  }
  std::filesystem::remove(file);
  CHECK_THROWS_AS(open_baked_raster(file), Error);
}

TEST_CASE("only whole numbers of 16 bits can be baked") {
  const TempFolder folder;
  RasterInfo info;
  info.path = "example";
  info.width = info.height = 1;
  for (const float v : {0.5f, 32768.0f, -32769.0f})
    CHECK_THROWS_AS(bake_raster(ArrayRaster(info, {v}), folder / "a.baked"), Error);
  CHECK(std::filesystem::is_empty(folder.path()));
}
