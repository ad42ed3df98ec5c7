// What a source may be besides a GeoTIFF: archives, other formats, colours; and the settings of an entry of a stack.
#include <doctest/doctest.h>
#include <gdal_utils.h>
#include <sys/stat.h>

#include <algorithm>
#include <future>

#include "base/error.h"
#include "rasters/source_test_tools.h"

using namespace nepho;
using namespace nepho::test;
namespace fs = std::filesystem;

namespace {

std::string copy_as(const std::string& driver, const std::string& from, const fs::path& to,
                    std::initializer_list<const char*> options = {}) {
  const GDALDatasetUniquePtr source(GDALDataset::Open(from.c_str()));
  REQUIRE(source != nullptr);
  GDALDriver* format = GetGDALDriverManager()->GetDriverByName(driver.c_str());
  if (!format) {
    MESSAGE("skipped: this GDAL has no " << driver);
    return "";
  }
  CPLStringList words;
  for (const char* option : options) words.AddString(option);
  GDALDatasetUniquePtr written(format->CreateCopy(to.c_str(), source.get(), FALSE, words.List(), nullptr, nullptr));
  REQUIRE_MESSAGE(written != nullptr, driver);
  return to.string();
}

}  // namespace

TEST_CASE("formats: the same heights come back from every format that GDAL writes here") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0, 121);
  recipe.geotransform = {10 - 0.5 / 120, 1.0 / 120, 0, 46 + 0.5 / 120, 0, -1.0 / 120};  // as DTED level 0 has it
  recipe.value = [](int, int x, int y) { return 10 * x + y; };
  const std::string tif = make_raster(folder / "a.tif", recipe);
  const auto expected = read_all(*elevation(tif));
  std::vector<std::string> names = {copy_as("DTED", tif, folder / "n45.dt0"), copy_as("netCDF", tif, folder / "a.nc"),
                                    copy_as("VRT", tif, folder / "a.vrt"), copy_as("AAIGrid", tif, folder / "a.asc"),
                                    copy_as("GPKG", tif, folder / "a.gpkg")};
  // In an archive.
  const std::string zip = "/vsizip/" + (folder / "a.zip").string() + "/inside/a.tif";
  VSILFILE* out = VSIFOpenL(zip.c_str(), "wb");
  REQUIRE(out != nullptr);
  const std::string bytes = bytes_of(tif);
  VSIFWriteL(bytes.data(), 1, bytes.size(), out);
  VSIFCloseL(out);
  names.push_back(zip);
  for (const std::string& name : names) {
    if (name.empty()) continue;
    CAPTURE(name);
    const auto raster = elevation(name);
    for (const auto& [lon, lat] : {std::pair{10.1, 45.2}, {10.5, 45.5}, {10.9, 45.95}}) {
      const auto x = static_cast<float>(std::floor((lon - recipe.geotransform[0]) * 120));
      const auto y = static_cast<float>(std::floor((recipe.geotransform[3] - lat) * 120));
      CHECK(values_at(*raster, lon, lat) == std::vector<float>{10 * x + y});
    }
  }
  const std::string jp2_source = make_raster(folder / "b.tif", [&] {
    RasterRecipe picture = recipe;
    picture.type = GDT_Byte;
    picture.bands = 3;
    picture.value = [](int b, int x, int y) { return (x + 2 * y + 60 * b) % 256; };
    return picture;
  }());
  const std::string jp2 = copy_as("JP2OpenJPEG", jp2_source, folder / "b.jp2", {"QUALITY=100", "REVERSIBLE=YES"});
  if (!jp2.empty()) CHECK(read_all(*imagery(jp2)).values == read_all(*imagery(jp2_source)).values);
}

TEST_CASE("warped data: overviews are used, so that far looks read little") {
  const TempFolder folder;
  for (const bool odd : {false, true}) {
    RasterRecipe recipe = square(0, 0, 1000, odd ? 3001 : 3072);
    recipe.height = odd ? 199 : 208;
    recipe.crs = "EPSG:32632";
    recipe.geotransform = {400000, 30, 0, 5300000, 0, -30};
    recipe.options = {"TILED=YES"};
    const std::string path = make_raster(folder / (odd ? "odd.tif" : "even.tif"), recipe);
    {
      // Each overview gets a height of its own, so that it can be told where a number comes from.
      GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_UPDATE));
      int halves[] = {2, 4, 8, 16};
      REQUIRE(dataset->BuildOverviews("NEAREST", 4, halves, 0, nullptr, nullptr, nullptr) == CE_None);
      for (int i = 0; i < 4; ++i) REQUIRE(dataset->GetRasterBand(1)->GetOverview(i)->Fill(100.0 * (i + 1)) == CE_None);
    }
    const auto raster = elevation(path);
    const double lon = 0.5 * (raster->info().bounds.west_deg + raster->info().bounds.east_deg);
    CHECK(values_at(*raster, lon, 47.82) == std::vector<float>{1000});
    REQUIRE(raster->reductions() >= 5);
    for (uint32_t k = 0; k < raster->reductions(); ++k) {
      const RasterBlock all = read_all(*raster, k);
      const float centre = all.values[size_t{all.height / 2} * all.width + all.width / 2];
      CAPTURE(k);
      CHECK(centre == (k <= 3 ? 1000.0f : 100.0f * static_cast<float>(k - 3)));  // 8 x 8 pixels of the file's pyramid
      CHECK(raster->pyramid_level(k) == (k <= 3 ? 0 : k - 3));
    }
  }
}

TEST_CASE("settings: opacity, vertical scale and datum of elevation") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0);
  recipe.value = [](int, int x, int) { return x == 0 ? -32768 : 100 * x; };
  const std::string path = make_raster(folder / "a.tif", recipe);
  const auto raster = elevation(path, {.opacity = 0.25, .vertical = VerticalDatum::ellipsoid, .vertical_scale = -2.5});
  CHECK(raster->info().opacity == 0.25);
  CHECK(raster->info().vertical == VerticalDatum::ellipsoid);
  CHECK(raster->read_block(0, 0, 0)->values[4] == -1000.0f);
  CHECK(raster->read_block(0, 0, 0)->valid[0] == 0);
  recipe.crs = "EPSG:4979";
  const std::string ellipsoidal = make_raster(folder / "b.tif", recipe);
  CHECK(elevation(ellipsoidal)->info().vertical == VerticalDatum::ellipsoid);
  CHECK(elevation(ellipsoidal, {.vertical = VerticalDatum::egm96})->info().vertical == VerticalDatum::egm96);
  CHECK(elevation(path)->info().vertical == VerticalDatum::egm96);
  CHECK(elevation(path)->info().fingerprint != raster->info().fingerprint);
  CHECK(elevation(path)->info().fingerprint == elevation(path)->info().fingerprint);
  CHECK(elevation(path)->info().fingerprint != elevation(ellipsoidal)->info().fingerprint);
}

TEST_CASE("settings: the stretch of pictures that are not 8 bits, and of those that are") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0);
  recipe.type = GDT_UInt16;
  recipe.value = [](int, int x, int y) { return 1000 + 10 * (20 * y + x); };  // 1000..4990
  const std::string path = make_raster(folder / "a.tif", recipe);
  const auto grey = [](const Raster& raster, size_t pixel) { return raster.read_block(0, 0, 0)->values[4 * pixel]; };
  CHECK(grey(*imagery(path), 0) == 0.0f);
  CHECK(grey(*imagery(path), 399) == 255.0f);
  CHECK(grey(*imagery(path), 200) ==
        doctest::Approx(255.0 * (200 - 3) / (395 - 3)).epsilon(1e-6));  // percentiles of 400
  CHECK(grey(*imagery(path, {.stretch = false}), 200) == doctest::Approx(3000 / 65535.0 * 255.0));
  const auto ranged = imagery(path, {.black_white = {{2000.0, 4000.0}}});
  CHECK(grey(*ranged, 0) == 0.0f);
  CHECK(grey(*ranged, 200) == doctest::Approx(127.5));
  CHECK(grey(*ranged, 399) == 255.0f);
  recipe.type = GDT_Float32;
  recipe.value = [](int, int x, int) { return x / 20.0; };
  const std::string floats = make_raster(folder / "f.tif", recipe);
  CHECK(grey(*imagery(floats, {.stretch = false}), 10) == doctest::Approx(127.5));
  recipe.type = GDT_Byte;
  recipe.value = [](int, int x, int) { return 10 * x; };
  const std::string bytes = make_raster(folder / "b.tif", recipe);
  CHECK(grey(*imagery(bytes), 10) == 100.0f);
  CHECK(grey(*imagery(bytes, {.black_white = {{50.0, 150.0}}}), 10) == doctest::Approx(127.5));
}

TEST_CASE("settings: opacity of pictures multiplies their alpha") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0);
  recipe.type = GDT_Byte;
  recipe.bands = 4;
  recipe.options = {"ALPHA=YES"};
  recipe.value = [](int b, int x, int) { return b < 3 ? 50 : x == 0 ? 0 : x == 1 ? 128 : 255; };
  const auto raster = imagery(make_raster(folder / "a.tif", recipe), {.opacity = 0.5});
  const RasterBlock block = *raster->read_block(0, 0, 0);
  CHECK(block.valid[0] == 0);
  CHECK(block.values[4 + 3] == 64.0f);
  CHECK(block.values[8 + 3] == 127.5f);
  CHECK(block.values[8] == 50.0f);
}

TEST_CASE("heights in the colours of one file are read too, and its reductions average metres, not colours") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0);
  recipe.type = GDT_Byte;
  recipe.bands = 3;
  // Columns of 255.5 m and 256 m: 127 255 128 and 129 0 0 in Terrarium.
  recipe.value = [](int b, int x, int) {
    constexpr int kNumbers[2][3] = {{128, 255, 128}, {129, 0, 0}};
    return kNumbers[x % 2][b];
  };
  const std::string path = make_raster(folder / "a.tif", recipe);
  const auto raster = elevation(path);
  CHECK(raster->read_block(0, 0, 0)->values[0] == 255.5f);
  CHECK(raster->read_block(0, 0, 0)->values[1] == 256.0f);
  CHECK(raster->read_block(1, 0, 0)->values[0] == 255.75f);
  CHECK(elevation(path, {.encoding = "terrarium"})->read_block(0, 0, 0)->values[0] == 255.5f);
  CHECK(elevation(path, {.encoding = "mapbox"})->info().bands == 1);
}

TEST_CASE("many threads get the same blocks as one") {
  const TempFolder folder;
  RasterRecipe recipe = square(0, 0, 0, 700);
  recipe.value = [](int, int x, int y) { return (x * 7 + y * 13) % 3000; };
  recipe.crs = "EPSG:32632";
  recipe.geotransform = {400000, 30, 0, 5300000, 0, -30};
  recipe.options = {"TILED=YES"};
  const std::string path = make_raster(folder / "a.tif", recipe);
  const RasterBlock alone = read_all(*elevation(path));
  const auto shared = elevation(path);
  std::vector<std::future<RasterBlock>> readers;
  for (int i = 0; i < 4; ++i) readers.push_back(std::async(std::launch::async, [&] { return read_all(*shared); }));
  for (auto& reader : readers) {
    const RasterBlock block = reader.get();
    CHECK(block.values == alone.values);
    CHECK(block.valid == alone.valid);
  }
}

TEST_CASE("bad input: pipes and devices are refused, not waited for") {
  const TempFolder folder;
  const std::string pipe = (folder / "pipe").string();
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  for (const std::string& name : {pipe, std::string("/dev/zero")})
    for (const bool heights : {false, true})
      CHECK(message_of([&] { heights ? elevation(name) : imagery(name); }, ErrorKind::input) ==
            name + ": is a pipe or device; give a file");
}
