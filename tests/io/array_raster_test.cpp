#include "io/array_raster.h"

#include <doctest/doctest.h>

#include <limits>

#include "io/raster_grid.h"

using namespace nepho;

namespace {

/// value = x + 1000 y
ArrayRaster ramp(uint32_t width, uint32_t height, std::vector<uint8_t> valid = {}) {
  std::vector<float> values(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) values[size_t{y} * width + x] = static_cast<float>(x + 1000 * y);
  return ArrayRaster({.path = "ramp", .width = width, .height = height, .bounds = {}}, std::move(values),
                     std::move(valid));
}

}  // namespace

TEST_CASE("array raster: reductions go on until one block holds everything") {
  CHECK(reduction_count(1, 1) == 1);
  CHECK(reduction_count(256, 256) == 1);
  CHECK(reduction_count(257, 1) == 2);
  CHECK(reduction_count(4320, 2161) == 6);       // 4320 / 32 = 135
  CHECK(reduction_count(4294967295u, 1) == 25);  // 2^32 / 2^24 = 256
  CHECK(block_window({.path = "", .width = 4294967295u, .height = 1, .bounds = {}}, 24, 0, 0)->width == 256);
}

TEST_CASE("array raster: blocks tile the raster, edge blocks are smaller, and no block lies outside") {
  const ArrayRaster raster = ramp(300, 270);
  CHECK(raster.reductions() == 2);
  const RasterBlock first = *raster.read_block(0, 0, 0);
  CHECK(first.width == 256);
  CHECK(first.height == 256);
  CHECK(first.values[256 * 7 + 5] == 7005.0f);
  const RasterBlock corner = *raster.read_block(0, 1, 1);
  CHECK(corner.width == 44);
  CHECK(corner.height == 14);
  CHECK(corner.values[0] == 256256.0f);
  CHECK(corner.values.back() == 269299.0f);
  CHECK_FALSE(raster.read_block(0, 2, 0));
  CHECK(raster.read_block(0, 2, 0).reason() == "ramp: has no block (2, 0) at reduction 0");
}

TEST_CASE("array raster: a reduced pixel is the mean of its own source pixels, fewer at the edge") {
  const ArrayRaster raster = ramp(301, 270);
  const RasterBlock half = *raster.read_block(1, 0, 0);
  CHECK(half.width == 151);
  CHECK(half.height == 135);
  CHECK(half.values[0] == 500.5f);             // 0, 1, 1000, 1001
  CHECK(half.values[151 * 2 + 3] == 4506.5f);  // columns 6, 7, rows 4, 5
  CHECK(half.values[150] == 800.0f);           // column 300 alone, rows 0, 1
  const RasterBlock quarter = *raster.read_block(2, 0, 0);
  CHECK(quarter.values[size_t{67} * quarter.width] == 268501.5f);  // rows 268, 269 alone, columns 0..3
}

TEST_CASE("array raster: only valid pixels count, and a pixel without any is invalid") {
  std::vector<uint8_t> valid(size_t{4} * 4, 1);
  for (const size_t i : {size_t{1}, size_t{4}, size_t{5}}) valid[i] = 0;                 // top left: only (0, 0)
  for (const size_t i : {size_t{10}, size_t{11}, size_t{14}, size_t{15}}) valid[i] = 0;  // bottom right: none
  const RasterBlock half = *ramp(4, 4, valid).read_block(1, 0, 0);
  CHECK(half.valid == std::vector<uint8_t>{1, 1, 1, 0});
  CHECK(half.values[0] == 0.0f);
  CHECK(half.values[1] == 502.5f);
}

TEST_CASE("array raster: a NaN is no value, and bands are averaged each for itself") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ArrayRaster raster({.path = "two", .width = 2, .height = 1, .bands = 2, .bounds = {}}, {nan, 5.0f, 7.0f, 9.0f});
  const RasterBlock block = *raster.read_block(0, 0, 0);
  CHECK(block.valid == std::vector<uint8_t>{0, 1});
  const RasterBlock half = *raster.read_block(1, 0, 0);
  CHECK(half.values == std::vector<float>{7.0f, 9.0f});
}
