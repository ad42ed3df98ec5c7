// What the numbers become: voids, units, datums, palettes, bit depths, reductions.
#include <doctest/doctest.h>

#include <limits>

#include "base/error.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;

namespace {

RasterRecipe recipe_of(int width, int height, int bands, GDALDataType type,
                       std::function<double(int, int, int)> value) {
  return {.width = width,
          .height = height,
          .bands = bands,
          .type = type,
          .geotransform = {10, 0.01, 0, 50, 0, -0.01},
          .crs = "EPSG:4326",
          .value = std::move(value)};
}

std::shared_ptr<Raster> elevation(const std::string& path) { return make_gdal_opener()->open_elevation(path); }
std::shared_ptr<Raster> imagery(const std::string& path) { return make_gdal_opener()->open_imagery(path); }

std::vector<float> pixel(const RasterBlock& block, size_t index) {
  return {block.values.begin() + static_cast<std::ptrdiff_t>(index * 4),
          block.values.begin() + static_cast<std::ptrdiff_t>(index * 4 + 4)};
}

}  // namespace

TEST_CASE("values: voids of every kind are invalid, and reductions average the rest") {
  const TempFolder folder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double declared : {-9999.0, 0.0, -32768.0, nan}) {  // 0: declared one, and undeclared kinds beside it
    CAPTURE(declared);
    const std::array<double, 4> top = {100.0, std::isnan(declared) ? nan : declared, -32768.0, 1e30};
    RasterRecipe recipe = recipe_of(
        4, 2, 1, GDT_Float32, [&](int, int x, int y) { return y == 0 ? top[static_cast<size_t>(x)] : 200.0 + x; });
    recipe.finish = [&](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(declared); };
    const auto raster = elevation(make_raster(folder / "void.tif", recipe));
    CHECK(raster->read_block(0, 0, 0)->valid == std::vector<uint8_t>{1, 0, 0, 0, 1, 1, 1, 1});
    const RasterBlock half = *raster->read_block(1, 0, 0);
    CHECK(half.values == std::vector<float>{167.0f, 202.5f});  // (100 + 200 + 201) / 3, (202 + 203) / 2
  }
}

TEST_CASE("values: a void is not blended into its neighbours when elevation is warped, declared or not") {
  const TempFolder folder;
  for (const bool declared : {true, false}) {
    CAPTURE(declared);
    RasterRecipe recipe = recipe_of(60, 60, 1, GDT_Int16, [](int, int x, int y) {
      return x > 20 && x < 30 && y > 20 && y < 30 ? -32768.0 : 500.0;
    });
    recipe.geotransform = {290000, 90, 0, 3920000, 0, -90};
    recipe.crs = "EPSG:32654";
    if (declared) recipe.finish = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-32768); };
    const RasterBlock all = read_all(*elevation(make_raster(folder / "hole.tif", recipe)));
    size_t holes = 0;
    float worst = 0.0f;
    for (size_t i = 0; i < all.valid.size(); ++i) {
      holes += all.valid[i] ? 0u : 1u;
      if (all.valid[i]) worst = std::max(worst, std::abs(all.values[i] - 500.0f));
    }
    CHECK(worst < 0.001f);
    CHECK(holes > 49);  // 9 x 9, less the rim that its neighbours reach
  }
}

TEST_CASE("values: feet, scale and offset become metres") {
  const TempFolder folder;
  RasterRecipe recipe = recipe_of(2, 2, 1, GDT_Int16, [](int, int, int) { return 1000.0; });
  recipe.finish = [](GDALDataset& d) { d.GetRasterBand(1)->SetUnitType("ft"); };
  CHECK(elevation(make_raster(folder / "feet.tif", recipe))->read_block(0, 0, 0)->values[0] == doctest::Approx(304.8));
  recipe.finish = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetScale(0.1);
    d.GetRasterBand(1)->SetOffset(-50.0);
  };
  CHECK(elevation(make_raster(folder / "scaled.tif", recipe))->read_block(0, 0, 0)->values[0] == doctest::Approx(50.0));
}

TEST_CASE("values: heights are above EGM96 unless the CRS says ellipsoid") {
  const TempFolder folder;
  struct Case {
    const char* crs;
    VerticalDatum datum;
    const char* warned;
  };
  for (const Case& c : {Case{"EPSG:4326", VerticalDatum::egm96, ""}, Case{"EPSG:4326+5773", VerticalDatum::egm96, ""},
                        Case{"EPSG:4979", VerticalDatum::ellipsoid, ""},
                        Case{"EPSG:4326+3855", VerticalDatum::egm96, "EGM2008 height"}}) {
    CAPTURE(c.crs);
    RasterRecipe recipe = recipe_of(4, 4, 1, GDT_Float32, [](int, int, int) { return 7.0; });
    recipe.crs = c.crs;
    const std::string path = make_raster(folder / "datum.tif", recipe);
    StderrCapture capture;
    const auto raster = elevation(path);
    const std::string said = capture.text();
    CHECK(raster->info().vertical == c.datum);
    CHECK(raster->info().width == 4);
    CHECK(raster->read_block(0, 0, 0)->values[0] == 7.0f);
    CHECK(said.empty() == std::string(c.warned).empty());
    CHECK(said.find(c.warned) != std::string::npos);
  }
}

TEST_CASE("values: grey, grey with alpha, RGB and RGBA come as RGBA; alpha 0 is invalid") {
  const TempFolder folder;
  const auto value = [](int band, int x, int) { return 10.0 * (band + 1) + x; };
  for (int bands = 1; bands <= 4; ++bands) {
    CAPTURE(bands);
    RasterRecipe recipe = recipe_of(2, 1, bands, GDT_Byte, value);
    recipe.options = {bands < 3 ? "PHOTOMETRIC=MINISBLACK" : "PHOTOMETRIC=RGB"};
    if (bands % 2 == 0) {
      recipe.options.push_back("ALPHA=YES");
      recipe.value = [=](int b, int x, int y) { return b == bands - 1 ? 128.0 * x : value(b, x, y); };
    }
    const RasterBlock block = *imagery(make_raster(folder / "bands.tif", recipe))->read_block(0, 0, 0);
    const float first = bands % 2 == 0 ? 0.0f : 255.0f, second = bands % 2 == 0 ? 128.0f : 255.0f;
    CHECK(block.valid == std::vector<uint8_t>{static_cast<uint8_t>(bands % 2), 1});
    CHECK(pixel(block, 1) ==
          (bands < 3 ? std::vector<float>{11, 11, 11, second} : std::vector<float>{11, 21, 31, second}));
    CHECK(block.values[3] == first);
  }
}

TEST_CASE("values: a picture is void only where all its bands are") {
  const TempFolder folder;
  RasterRecipe recipe =
      recipe_of(2, 1, 3, GDT_Byte, [](int band, int x, int) { return x == 1 && band == 2 ? 9.0 : 0.0; });
  recipe.finish = [](GDALDataset& d) {
    for (int b = 1; b <= 3; ++b) d.GetRasterBand(b)->SetNoDataValue(0);
  };
  const RasterBlock block = *imagery(make_raster(folder / "nodata.tif", recipe))->read_block(0, 0, 0);
  CHECK(block.valid == std::vector<uint8_t>{0, 1});
  CHECK(pixel(block, 1) == std::vector<float>{0, 0, 9, 255});
}

TEST_CASE("values: a mask band makes pixels invalid") {
  const TempFolder folder;
  RasterRecipe recipe = recipe_of(3, 1, 3, GDT_Byte, [](int, int x, int) { return 50.0 + x; });
  recipe.finish = [](GDALDataset& d) {
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    REQUIRE(d.CreateMaskBand(GMF_PER_DATASET) == CE_None);
    std::array<uint8_t, 3> mask = {255, 0, 255};
    REQUIRE(d.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 3, 1, mask.data(), 3, 1, GDT_Byte, 0, 0,
                                                        nullptr) == CE_None);
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  };
  CHECK(imagery(make_raster(folder / "mask.tif", recipe))->read_block(0, 0, 0)->valid == std::vector<uint8_t>{1, 0, 1});
}

TEST_CASE("values: palettes become colours, as they are and warped; the transparent index is invalid") {
  const TempFolder folder;
  for (const bool warped : {false, true}) {
    CAPTURE(warped);
    RasterRecipe recipe = recipe_of(40, 40, 1, GDT_Byte, [](int, int x, int) {
      return x < 20 ? 3.0 : x < 30 ? 200.0 : 7.0;
    });
    recipe.finish = [](GDALDataset& d) {
      GDALColorTable colors;
      const GDALColorEntry red{250, 10, 20, 255}, blue{0, 0, 240, 255}, grey{128, 128, 128, 255};
      colors.SetColorEntry(3, &red);
      colors.SetColorEntry(200, &blue);
      colors.SetColorEntry(7, &grey);
      REQUIRE(d.GetRasterBand(1)->SetColorTable(&colors) == CE_None);
      d.GetRasterBand(1)->SetNoDataValue(7);
    };
    if (warped) {
      recipe.geotransform = {290000, 90, 0, 3920000, 0, -90};
      recipe.crs = "EPSG:32654";
    }
    const auto raster = imagery(make_raster(folder / "palette.tif", recipe));
    const RasterInfo& info = raster->info();
    const double lat = 0.5 * (info.bounds.north_deg + info.bounds.south_deg);
    const auto lon = [&](double share) {
      return info.bounds.west_deg + share * (info.bounds.east_deg - info.bounds.west_deg);
    };
    CHECK(values_at(*raster, lon(0.3), lat) == std::vector<float>{250, 10, 20, 255});
    CHECK(values_at(*raster, lon(0.63), lat) == std::vector<float>{0, 0, 240, 255});
    CHECK(values_at(*raster, lon(0.9), lat).empty());
  }
}

TEST_CASE(
    "values: 16-bit and float pictures are stretched from the 1st to the 99th percentile, 16-bit PNG by its range") {
  const TempFolder folder;
  // 0 .. 9999 once each: percentiles are 99.99 and 9899.01, indices cut to 99 and 9899.
  const auto ramp = [](int, int x, int y) { return x + 100.0 * y; };
  for (const GDALDataType type : {GDT_UInt16, GDT_Float32}) {
    const RasterBlock block =
        *imagery(make_raster(folder / "deep.tif", recipe_of(100, 100, 1, type, ramp)))->read_block(0, 0, 0);
    CHECK(block.values[4 * 99] == 0.0f);
    CHECK(block.values[0] == 0.0f);
    CHECK(block.values[4 * 9899] == doctest::Approx(255.0));
    CHECK(block.values[4 * 9999] == 255.0f);
    CHECK(block.values[4 * 4999] == doctest::Approx(127.5));  // half way
    CHECK(block.values[4 * 4999 + 3] == 255.0f);
  }
  RasterRecipe png = recipe_of(100, 50, 1, GDT_UInt16, [](int, int x, int y) { return 257.0 * (x % 64) + y * 0.0; });
  png.driver = "PNG";
  png.geotransform = {};
  png.crs.clear();
  const std::string png_path = make_raster(folder / "deep.png", png);
  const StderrCapture warning;
  const RasterBlock block = *imagery(png_path)->read_block(0, 0, 0);
  CHECK(block.values[4 * 63] == doctest::Approx(63.0));
}

TEST_CASE("values: reductions of a picture average its own pixels; a matching pyramid of the file is used from 16 on") {
  const TempFolder folder;
  RasterRecipe recipe = recipe_of(8192, 64, 1, GDT_Byte, [](int, int x, int y) { return (x * 7 + y * 3) % 251; });
  recipe.options = {"TILED=YES"};
  const std::string path = make_raster(folder / "wide.tif", recipe);
  const auto raster = elevation(path);
  CHECK(raster->reductions() == 6);
  std::vector<RasterBlock> plain;
  for (uint32_t k = 0; k < 6; ++k) plain.push_back(read_all(*raster, k));
  for (uint32_t k = 1; k < 6; ++k) {
    const uint32_t side = 1u << k, column = plain[k].width - 3, row = 1;
    double sum = 0.0;
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) sum += ((column * side + x) * 7 + (row * side + y) * 3) % 251;
    CHECK(static_cast<double>(plain[k].values[size_t{row} * plain[k].width + column]) ==
          doctest::Approx(sum / side / side));
  }
  {  // A pyramid of another number shows which level is read.
    GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    std::array<int, 2> factors = {2, 4};
    REQUIRE(dataset->BuildOverviews("NEAREST", 2, factors.data(), 0, nullptr, GDALDummyProgress, nullptr) == CE_None);
    for (int i = 0; i < 2; ++i) REQUIRE(dataset->GetRasterBand(1)->GetOverview(i)->Fill(240 + i) == CE_None);
  }
  const auto pyramid = elevation(path);
  for (uint32_t k = 0; k < 4; ++k) CHECK(read_all(*pyramid, k).values == plain[k].values);
  CHECK(pyramid->read_block(4, 0, 0)->values[5] == 240.0f);
  CHECK(pyramid->read_block(5, 0, 0)->values[5] == 241.0f);
}
