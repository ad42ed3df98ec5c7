// Cloud cover 0..1 out of every kind of file (docs/weather.md, 'What a file means').
#include <doctest/doctest.h>

#include <algorithm>

#include "base/error.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"
#include "render/shared_data.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr std::array<double, 6> kGlobe = {-180, 5, 0, 90, 0, -5};  // 72 x 36

RasterRecipe recipe(GDALDataType type, int bands, std::function<double(int, int, int)> value) {
  return {.width = 72,
          .height = 36,
          .bands = bands,
          .type = type,
          .geotransform = kGlobe,
          .crs = "EPSG:4326",
          .value = std::move(value)};
}

std::vector<float> first_pixel(const Raster& raster) {
  const RasterBlock all = read_all(raster);
  return {all.values.begin(), all.values.begin() + raster.info().bands};
}

void check_cover(const std::string& path, const std::vector<float>& expected) {
  CAPTURE(path);
  const auto raster = make_gdal_opener()->open_weather(path);
  const std::vector<float> found = first_pixel(*raster);
  REQUIRE(found.size() == expected.size());
  for (size_t i = 0; i < found.size(); ++i) CHECK(found[i] == doctest::Approx(expected[i]).epsilon(1e-5));
}

void check_refused(const std::string& path, const std::string& found) {
  const std::string message = message_of([&] { make_gdal_opener()->open_weather(path); }, ErrorKind::input);
  CHECK_MESSAGE(message.find(path + ": ") == 0, message);
  CHECK_MESSAGE(message.find(found) != std::string::npos, message);
}

}  // namespace

TEST_CASE("weather: one band is total cover; bytes and 16 bits by their range, fractions and percent by their values") {
  const TempFolder folder;
  const auto one = [&](const char* name, GDALDataType type, double first, double second) {
    return make_raster(folder / name, recipe(type, 1, [=](int, int x, int y) { return x + y == 0 ? first : second; }));
  };
  check_cover(one("byte.tif", GDT_Byte, 51, 255), {0.2f});
  check_cover(one("word.tif", GDT_UInt16, 13107, 65535), {0.2f});
  check_cover(one("word_percent.tif", GDT_UInt16, 40, 100), {0.4f});
  check_cover(one("fraction.tif", GDT_Float32, 0.25, 1.0), {0.25f});
  check_cover(one("percent.tif", GDT_Float32, 25.0, 100.0), {0.25f});
  check_cover(one("percent_int.tif", GDT_Int16, 25, 99), {0.25f});
  check_refused(one("kelvin.tif", GDT_Float32, 199.5, 333.0), "values from 199.5 to 333 are no cloud cover");
  check_refused(one("negative.tif", GDT_Float32, -3.0, 0.5), "values from -3 to 0.5 are no cloud cover");
  // Packed: what counts is the number that it stands for.
  RasterRecipe packed = recipe(GDT_Int16, 1, [](int, int x, int y) { return x + y == 0 ? -15000 : 20000; });
  packed.finish = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetScale(2e-5);
    d.GetRasterBand(1)->SetOffset(0.5);
  };
  check_cover(make_raster(folder / "packed.tif", packed), {0.2f});
}

TEST_CASE("weather: grey pictures are grey times opacity, coloured ones are four channels") {
  const TempFolder folder;
  check_cover(make_raster(folder / "grey.tif", recipe(GDT_Byte, 3, [](int, int x, int) { return x == 0 ? 102 : x; })),
              {0.4f});
  RasterRecipe rgb = recipe(GDT_Byte, 3, [](int b, int, int) { return 51 * (b + 1); });
  check_cover(make_raster(folder / "rgb.tif", rgb), {0.2f, 0.4f, 0.6f, 0.0f});
  RasterRecipe rgba = recipe(GDT_Byte, 4, [](int b, int, int) { return 51 * (b + 1); });
  rgba.driver = "PNG";  // the fourth band is alpha, which is a channel here
  rgba.geotransform = {};
  rgba.crs = {};
  check_cover(make_raster(folder / "rgba.png", rgba), {0.2f, 0.4f, 0.6f, 0.8f});
  rgba.value = [](int b, int x, int y) { return b < 3 ? 204 : x + y == 0 ? 128.0 : 0.0; };
  check_cover(make_raster(folder / "white.png", rgba), {0.8f * 128.0f / 255.0f});
  const auto clear = make_gdal_opener()->open_weather((folder / "white.png").string());
  const RasterBlock all = read_all(*clear);
  CHECK(all.valid[5] == 1);  // transparent is clear sky, not a hole
  CHECK(all.values[5] == 0.0f);
}

TEST_CASE("weather: palettes are their colours; the index without data is a hole") {
  const TempFolder folder;
  RasterRecipe r = recipe(GDT_Byte, 1, [](int, int x, int) { return x % 3; });
  r.finish = [](GDALDataset& d) {
    GDALColorTable colors;
    const GDALColorEntry entries[] = {{102, 102, 102, 255}, {255, 255, 255, 255}, {0, 0, 0, 255}};
    for (int i = 0; i < 3; ++i) colors.SetColorEntry(i, &entries[i]);
    REQUIRE(d.GetRasterBand(1)->SetColorTable(&colors) == CE_None);
    REQUIRE(d.GetRasterBand(1)->SetNoDataValue(2) == CE_None);
  };
  const auto raster = make_gdal_opener()->open_weather(make_raster(folder / "palette.tif", r));
  const RasterBlock all = read_all(*raster);
  REQUIRE(raster->info().bands == 1);
  CHECK(all.values[0] == doctest::Approx(0.4f));
  CHECK(all.values[1] == 1.0f);
  CHECK(all.valid[1] == 1);
  CHECK(all.valid[2] == 0);
}

TEST_CASE("weather: a projected raster keeps its values and knows its outside") {
  const TempFolder folder;
  RasterRecipe r = recipe(GDT_Float32, 1, [](int, int, int) { return 0.7; });
  r.crs = "EPSG:3995";  // around the north pole
  r.width = r.height = 64;
  r.geotransform = {-3.2e6, 1e5, 0, 3.2e6, 0, -1e5};
  const auto raster = make_gdal_opener()->open_weather(make_raster(folder / "polar.tif", r));
  CHECK(values_at(*raster, 20.0, 80.0).at(0) == doctest::Approx(0.7f));
  CHECK(values_at(*raster, -160.0, 70.0).at(0) == doctest::Approx(0.7f));
  CHECK(raster->info().wraps);
  // Channels survive a warp too, the fourth included.
  r.bands = 4;
  r.type = GDT_Byte;
  r.value = [](int b, int, int) { return 51 * (b + 1); };
  r.finish = [](GDALDataset& d) { d.GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand); };
  const auto channels = make_gdal_opener()->open_weather(make_raster(folder / "channels.tif", r));
  const std::vector<float> v = values_at(*channels, 20.0, 80.0);
  REQUIRE(v.size() == 4);
  for (size_t b = 0; b < 4; ++b) CHECK(v[b] == doctest::Approx(0.2 * double(b + 1)).epsilon(0.01));
}

TEST_CASE("weather: bad inputs are one line each") {
  const TempFolder folder;
  check_refused((folder / "missing.png").string(), "no such file");
  RasterRecipe r = recipe(GDT_Byte, 5, [](int, int x, int) { return x; });
  check_refused(make_raster(folder / "five.tif", r), "has 5 bands; weather has one of cloud cover, or RGB or RGBA");
  r.bands = 2;
  r.options = {"ALPHA=NO"};
  check_refused(make_raster(folder / "two.tif", r), "has 2 bands");
  r = recipe(GDT_Byte, 1, [](int, int x, int) { return x; });
  r.geotransform = {};
  r.crs = {};
  r.width = 71;
  check_refused(make_raster(folder / "nowhere.tif", r), "71 x 36 pixels without georeference");
  r = recipe(GDT_CFloat32, 1, [](int, int, int) { return 0.5; });
  check_refused(make_raster(folder / "complex.tif", r), "holds complex numbers");
}

TEST_CASE("weather: a tile needs no place, and has a largest size") {
  const TempFolder folder;
  RasterRecipe r = recipe(GDT_Byte, 3, [](int b, int, int) { return 51 * (b + 1); });
  r.geotransform = {};
  r.crs = {};
  r.width = 50;
  r.height = 33;
  r.driver = "PNG";
  const auto opener = make_gdal_opener();
  StderrCapture capture;
  const auto tile = opener->open_tile(make_raster(folder / "tile.png", r));
  CHECK(capture.text().empty());
  CHECK(tile->info().width == 50);
  CHECK(tile->info().height == 33);
  const std::vector<float> v = first_pixel(*tile);
  REQUIRE(v.size() == 4);
  CHECK(v[2] == doctest::Approx(0.6f));
  CHECK(v[3] == 0.0f);
  r = recipe(GDT_Byte, 1, [](int, int, int) { return 1; });
  r.width = 4097;
  r.height = 1;
  const std::string path = make_raster(folder / "long.tif", r);
  CHECK(message_of([&] { opener->open_tile(path); }, ErrorKind::input) ==
        path + ": is 4097 x 1 pixels; a weather tile has at most 4096 a side");
}

TEST_CASE("weather: real satellite pictures and a forecast") {
  const auto opener = make_gdal_opener();
  if (const std::string file = shared_data("satellite/threeglobe_fair_clouds_4096.png"); !file.empty()) {
    const auto raster = opener->open_weather(file);
    CHECK(raster->info().bands == 1);
    const RasterBlock all = read_all(*raster, 4);
    double sum = 0.0;
    for (const float v : all.values) sum += static_cast<double>(v);
    const double mean = sum / static_cast<double>(all.values.size());
    CHECK((mean > 0.05 && mean < 0.4));  // its white would be 1 everywhere
  }
  if (const std::string file = shared_data("satellite/nasa_cloud_combined_2048.jpg"); !file.empty())
    CHECK(opener->open_weather(file)->info().bands == 1);
  if (const std::string file = shared_data("weather/gfs_2011100800_f072_clouds_era5layout_DERIVED.nc"); !file.empty()) {
    const auto raster = opener->open_weather("NETCDF:\"" + file + "\":tcc");
    const RasterBlock all = read_all(*raster);
    CHECK(*std::max_element(all.values.begin(), all.values.end()) > 0.95f);
    CHECK(*std::min_element(all.values.begin(), all.values.end()) < 0.05f);
  }
  if (const std::string file = shared_data("satellite/msg_seviri_ir108_mercator.nc"); !file.empty())
    check_refused(file, "are no cloud cover");
  if (const std::string file = shared_data("weather/gfs_2p5deg_2011100800_f072.grib2"); !file.empty())
    check_refused(file, "has 344 bands");
}
