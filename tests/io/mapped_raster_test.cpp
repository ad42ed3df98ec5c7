#include <doctest/doctest.h>

#include "io/array_raster.h"
#include "io/mapped_raster.h"

using namespace nepho;

TEST_CASE("mapped imagery: colours follow the curve, alpha and validity stay") {
  RasterInfo info;
  info.path = "test";
  info.width = info.height = 1;
  info.bands = 4;
  info.bounds = {0, 0, 1, 1};
  const auto source = std::make_shared<ArrayRaster>(info, std::vector<float>{0.0f, 255.0f, 10.5f, 77.0f});
  std::array<float, 256> curve;
  for (size_t i = 0; i < 256; ++i) curve[i] = 5.0f + 0.5f * static_cast<float>(i);
  const Result<RasterBlock> block = make_mapped_imagery(source, curve)->read_block(0, 0, 0);
  REQUIRE(block);
  CHECK(block->values[0] == 5.0f);
  CHECK(block->values[1] == 132.5f);
  CHECK(block->values[2] == doctest::Approx(10.25f));
  CHECK(block->values[3] == 77.0f);
  CHECK(block->valid[0] == 1);
}

TEST_CASE("albedo curve: offset 0 and scale 1 change nothing; black becomes the offset") {
  const auto same = albedo_curve(0.0f, 1.0f);
  for (size_t i = 0; i < 256; ++i) CHECK(same[i] == doctest::Approx(static_cast<double>(i)).epsilon(1e-4));
  const float s = albedo_curve(0.02f, 0.82f)[0] / 255.0f;
  CHECK(std::pow((s + 0.055f) / 1.055f, 2.4f) == doctest::Approx(0.02).epsilon(1e-3));
}

TEST_CASE("albedo curve: gamma lightens the middle tones before the scale, and albedo ends at 1") {
  const auto lighter = albedo_curve(0.0f, 1.0f, 2.0f), darker = albedo_curve(0.0f, 1.0f, 0.5f);
  CHECK(lighter[0] == 0.0f);
  CHECK(lighter[255] == doctest::Approx(255.0));
  CHECK(lighter[64] == doctest::Approx(255.0 * std::sqrt(64.0 / 255.0)).epsilon(1e-4));
  CHECK(darker[128] == doctest::Approx(128.0 * 128.0 / 255.0).epsilon(1e-4));
  // Half the albedo of white is sRGB 0.7354 (IEC 61966-2-1: 1.055 * 0.5^(1/2.4) - 0.055).
  CHECK(albedo_curve(0.0f, 0.5f)[255] == doctest::Approx(255.0 * 0.735357).epsilon(1e-4));
  CHECK(albedo_curve(0.0f, 3.0f)[255] == doctest::Approx(255.0));
}
