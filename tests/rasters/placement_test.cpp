// Where pixels end up: CRSs, longitudes, row orders. Heights are a known function of the place, so that a shift by a
// fraction of a pixel shows.
#include <doctest/doctest.h>

#include <stdexcept>
#include <thread>

#include "base/error.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr double kPerLon_m = 50.0, kPerLat_m = 100.0;

double plane(double lon_deg, double lat_deg) { return kPerLon_m * lon_deg + kPerLat_m * lat_deg; }

/// A raster in `crs` whose heights are plane() of the true longitude (counted on from `lon0`) and latitude.
RasterRecipe plane_in(const std::string& crs, int width, int height, const std::array<double, 6>& g, double lon0) {
  const OGRSpatialReference from = srs_of(crs), to = srs_of("EPSG:4326");
  std::shared_ptr<OGRCoordinateTransformation> lon_lat(OGRCreateCoordinateTransformation(&from, &to));
  REQUIRE(lon_lat != nullptr);
  return {.width = width, .height = height, .geotransform = g, .crs = crs, .value = [=](int, int column, int row) {
            double x = g[0] + g[1] * (column + 0.5) + g[2] * (row + 0.5),
                   y = g[3] + g[4] * (column + 0.5) + g[5] * (row + 0.5);
            if (!lon_lat->Transform(1, &x, &y)) throw std::runtime_error("a pixel without a place");
            return plane(lon0 + std::remainder(x - lon0, 360.0), y);
          }};
}

/// Largest difference from plane() over the valid pixels, and how many of these there are.
std::pair<double, size_t> worst_error(const Raster& raster) {
  const RasterBlock all = read_all(raster);
  double worst = 0.0;
  size_t count = 0;
  for (uint32_t row = 0; row < all.height; ++row)
    for (uint32_t column = 0; column < all.width; ++column) {
      const size_t i = size_t{row} * all.width + column;
      if (!all.valid[i]) continue;
      ++count;
      const double truth = plane(lon_of(raster.info(), column), lat_of(raster.info(), row));
      worst = std::max(worst, std::abs(static_cast<double>(all.values[i]) - truth));
    }
  return {worst, count};
}

}  // namespace

TEST_CASE("placement: a UTM raster is warped without a shift") {
  const TempFolder folder;
  // 90 m pixels near Fuji, zone 54 N.
  const std::string path =
      make_raster(folder / "utm.tif", plane_in("EPSG:32654", 300, 200, {290000, 90, 0, 3920000, 0, -90}, 138.7));
  const auto raster = make_gdal_opener()->open_elevation(path);
  const RasterInfo& info = raster->info();
  CHECK(info.wraps == false);
  // Corners from GeographicLib (GeoConvert): 290000 3920000 -> 138.690526 35.402600, 317000 3902000 ->
  // 138.991742 35.245440.
  CHECK(info.bounds.west_deg == doctest::Approx(138.686).epsilon(5e-5));
  CHECK(info.bounds.north_deg == doctest::Approx(35.407).epsilon(5e-5));
  const auto [worst, count] = worst_error(*raster);
  // A pixel is 0.05 m east to west and 0.08 m north to south here; edges extrapolate by up to half a pixel.
  CHECK(worst < 0.07);
  CHECK(count > size_t{300} * 200 * 9 / 10);
  const double steps = (info.bounds.north_deg - info.bounds.south_deg) / info.height * 111e3;
  CHECK(steps == doctest::Approx(90.0).epsilon(0.02));  // resolution kept
  // Away from the edges only the warper's own tolerance is left: 0.05 px is 0.0065 m,
  // and a float of 10,000 m is good to 0.001 m.
  const auto middle = values_at(*raster, 138.84, 35.32);
  REQUIRE(middle.size() == 1);
  const auto [column, row] = pixel_at(info, 138.84, 35.32);
  CHECK(std::abs(static_cast<double>(middle[0]) - plane(lon_of(info, column), lat_of(info, row))) < 0.0075);
}

TEST_CASE("placement: a UTM raster across the antimeridian keeps its east above 180") {
  const TempFolder folder;
  // Zone 1 N has its centre at 177 W: easting 100 km at 60 N is about 175.9 E.
  const std::string path =
      make_raster(folder / "date.tif", plane_in("EPSG:32601", 400, 120, {150000, 1000, 0, 6700000, 0, -1000}, 180.0));
  const auto raster = make_gdal_opener()->open_elevation(path);
  const RasterInfo& info = raster->info();
  CHECK(info.wraps == false);
  CHECK(info.bounds.west_deg > 176.0);
  CHECK(info.bounds.west_deg < 178.0);
  CHECK(info.bounds.east_deg > 183.0);
  CHECK(info.bounds.east_deg < 186.0);
  const auto [worst, count] = worst_error(*raster);
  CHECK(worst < 0.75 * (0.9 + 0.9));  // a pixel is 0.018 deg by 0.009 deg; half of one at the rim, curved
  CHECK(count > size_t{400} * 120 * 8 / 10);
  CHECK(values_at(*raster, 179.999, 60.0).size() == 1);
  CHECK(values_at(*raster, -179.999, 60.0).size() == 1);
}

TEST_CASE("placement: a raster around the pole becomes a global strip up to 90 degrees") {
  const TempFolder folder;
  const OGRSpatialReference from = srs_of("EPSG:3413"), to = srs_of("EPSG:4326");
  std::shared_ptr<OGRCoordinateTransformation> lon_lat(OGRCreateCoordinateTransformation(&from, &to));
  RasterRecipe recipe{
      .width = 200,
      .height = 200,
      .geotransform = {-1e6, 1e4, 0, 1e6, 0, -1e4},
      .crs = "EPSG:3413",
  };
  recipe.value = [=](int, int column, int row) {
    double x = -1e6 + 1e4 * (column + 0.5), y = 1e6 - 1e4 * (row + 0.5);
    if (!lon_lat->Transform(1, &x, &y)) throw std::runtime_error("a pixel without a place");
    return 100.0 * y;
  };
  const auto raster = make_gdal_opener()->open_elevation(make_raster(folder / "polar.tif", recipe));
  const RasterInfo& info = raster->info();
  CHECK(info.wraps);
  CHECK(info.bounds.north_deg == 90.0);
  CHECK(info.bounds.east_deg - info.bounds.west_deg == doctest::Approx(360.0));
  for (const double lon : {-179.9, -90.0, 0.0, 90.0, 179.9})
    for (const double lat : {83.0, 86.0, 88.0, 89.9}) {
      const auto value = values_at(*raster, lon, lat);
      REQUIRE(value.size() == 1);
      const double centre = lat_of(info, pixel_at(info, lon, lat).second);
      // The cone of heights is flat within half a pixel (5 km, 0.045 deg) of the pole.
      CHECK(std::abs(static_cast<double>(value[0]) - 100.0 * centre) < (lat > 89.0 ? 6.0 : 0.5));
    }
}

TEST_CASE("placement: longitudes are brought in reach of -180..180, and a raster across 180 stays whole") {
  const TempFolder folder;
  struct Case {
    double first_lon;
    int columns;
    double pixel, west, east;
    bool wraps;
  };
  const Case cases[] = {
      {340, 30, 1.0, -20, 10, false},   // 340..370
      {175, 10, 1.0, 175, 185, false},  // across
      {200, 10, 1.0, -160, -150, false},
      {0, 360, 1.0, 0, 360, true},          // edges at 0 and 360
      {-0.5, 360, 1.0, -0.5, 359.5, true},  // centres at 0..359
      {-180, 720, 0.5, -180, 180, true},
      {-0.5, 361, 1.0, -0.5, 359.5, true},  // 0 and 360 both given: the last column repeats the first
      {-0.041667, 4320, 0.083334, -0.041667, 359.958333, true},  // an axis rounded to 5 digits
      {180, 360, 1.0, -180, 180, true},
  };
  const auto opener = make_gdal_opener();
  for (const Case& c : cases) {
    CAPTURE(c.first_lon);
    CAPTURE(c.columns);
    RasterRecipe recipe{.width = c.columns,
                        .height = 4,
                        .geotransform = {c.first_lon, c.pixel, 0, 2, 0, -1},
                        .crs = "EPSG:4326",
                        .value = [](int, int x, int) { return x; }};
    const auto raster = opener->open_elevation(make_raster(folder / "lon.tif", recipe));
    CHECK(raster->info().bounds.west_deg == doctest::Approx(c.west).epsilon(1e-6));
    CHECK(raster->info().bounds.east_deg == doctest::Approx(c.east).epsilon(1e-6));
    CHECK(raster->info().wraps == c.wraps);
    CHECK(raster->info().width == static_cast<uint32_t>(c.columns == 361 ? 360 : c.columns));
    const RasterBlock all = read_all(*raster);
    CHECK(all.values.front() == 0.0f);
    CHECK(all.values.back() == static_cast<float>(raster->info().width - 1));
  }
}

TEST_CASE("placement: rows beyond a pole are left out, rows centred on it stay") {
  const TempFolder folder;
  const auto opener = make_gdal_opener();
  RasterRecipe recipe{.width = 8,
                      .height = 185,
                      .geotransform = {0, 1, 0, 92.5, 0, -1},
                      .crs = "EPSG:4326",
                      .value = [](int, int, int y) { return 92.0 - y; }};
  const auto raster = opener->open_elevation(make_raster(folder / "rows.tif", recipe));
  CHECK(raster->info().height == 181);
  CHECK(raster->info().bounds.north_deg == doctest::Approx(90.5));
  CHECK(raster->info().bounds.south_deg == doctest::Approx(-90.5));
  CHECK(values_at(*raster, 3.0, 90.0) == std::vector<float>{90.0f});
  CHECK(values_at(*raster, 3.0, -90.0) == std::vector<float>{-90.0f});
}

TEST_CASE("placement: rows from south to north and columns from east to west are turned") {
  const TempFolder folder;
  const auto opener = make_gdal_opener();
  for (const bool flip_x : {false, true})
    for (const bool flip_y : {false, true}) {
      CAPTURE(flip_x);
      CAPTURE(flip_y);
      const std::array<double, 6> g = {flip_x ? 20.0 : 10.0, flip_x ? -0.02 : 0.02, 0, flip_y ? 40.0 : 50.0, 0,
                                       flip_y ? 0.02 : -0.02};
      RasterRecipe recipe{
          .width = 500, .height = 500, .geotransform = g, .crs = "EPSG:4326", .value = [=](int, int x, int y) {
            return plane(g[0] + g[1] * (x + 0.5), g[3] + g[5] * (y + 0.5));
          }};
      const auto raster = opener->open_elevation(make_raster(folder / "turned.tif", recipe));
      CHECK(raster->info().bounds.west_deg == doctest::Approx(10.0));
      CHECK(raster->info().bounds.north_deg == doctest::Approx(50.0));
      const auto [worst, count] = worst_error(*raster);
      CHECK(count == 250000);
      CHECK(worst < 0.001);  // floats of 6,000 m
    }
}

TEST_CASE("placement: NAD83 is used as it is, OSGB36 is moved by its datum shift") {
  const TempFolder folder;
  const auto opener = make_gdal_opener();
  RasterRecipe recipe{.width = 40,
                      .height = 40,
                      .geotransform = {-0.2, 0.01, 0, 51.7, 0, -0.01},
                      .crs = "EPSG:4269",
                      .value = [](int, int x, int y) { return x + 100.0 * y; }};
  const auto same = opener->open_elevation(make_raster(folder / "nad83.tif", recipe));
  CHECK(same->info().width == 40);
  CHECK(same->info().bounds.west_deg == -0.2);
  CHECK(read_all(*same).values[41] == 101.0f);
  recipe.crs = "EPSG:4277";  // London: WGS84 is 0.0016 deg west and 0.0005 deg north of OSGB36
  const auto moved = opener->open_elevation(make_raster(folder / "osgb.tif", recipe));
  CHECK(moved->info().bounds.west_deg == doctest::Approx(-0.2016).epsilon(1e-3));
  CHECK(moved->info().bounds.north_deg == doctest::Approx(51.7005).epsilon(1e-5));
}

TEST_CASE("placement: control points place a picture") {
  const TempFolder folder;
  RasterRecipe recipe{.width = 100, .height = 100, .value = [](int, int x, int y) {
                        return plane(5.0 + 0.01 * (x + 0.5), 45.0 - 0.01 * (y + 0.5));
                      }};
  recipe.finish = [](GDALDataset& dataset) {
    std::vector<GDAL_GCP> points(4);
    GDALInitGCPs(4, points.data());
    for (size_t i = 0; i < 4; ++i) {
      points[i].dfGCPPixel = i % 2 ? 100 : 0;
      points[i].dfGCPLine = i / 2 ? 100 : 0;
      points[i].dfGCPX = 5.0 + 0.01 * points[i].dfGCPPixel;
      points[i].dfGCPY = 45.0 - 0.01 * points[i].dfGCPLine;
    }
    const OGRSpatialReference srs = srs_of("EPSG:4326");
    REQUIRE(dataset.SetGCPs(4, points.data(), &srs) == CE_None);
    GDALDeinitGCPs(4, points.data());
  };
  const auto raster = make_gdal_opener()->open_elevation(make_raster(folder / "gcp.tif", recipe));
  CHECK(raster->info().bounds.west_deg == doctest::Approx(5.0));
  CHECK(raster->info().bounds.north_deg == doctest::Approx(45.0));
  CHECK(worst_error(*raster).first < 0.03);  // 0.05 px
}

TEST_CASE(
    "placement: degrees without a CRS are EPSG:4326; a 2:1 picture without anything is the globe, with one warning") {
  const TempFolder folder;
  const auto opener = make_gdal_opener();
  RasterRecipe recipe{
      .width = 64, .height = 32, .geotransform = {10, 0.1, 0, 50, 0, -0.1}, .value = [](int, int x, int y) {
        return x + y;
      }};
  const auto local = opener->open_elevation(make_raster(folder / "degrees.tif", recipe));
  CHECK(local->info().bounds.east_deg == doctest::Approx(16.4));
  recipe.geotransform = {};
  const std::string path = make_raster(folder / "globe.tif", recipe);
  StderrCapture capture;
  const auto globe = opener->open_elevation(path);
  opener->open_imagery(path);
  CHECK(capture.text() ==
        "nepho: warning: " + path + ": no georeference; 2:1, so taken as the whole globe, longitude -180 to 180\n");
  CHECK(globe->info().wraps);
  CHECK(globe->info().bounds.west_deg == -180.0);
  CHECK(globe->info().bounds.south_deg == -90.0);
}

TEST_CASE("placement: blocks are the same whichever is asked first, from whichever thread") {
  const TempFolder folder;
  const std::string path =
      make_raster(folder / "utm.tif", plane_in("EPSG:32654", 700, 600, {290000, 90, 0, 3920000, 0, -90}, 138.7));
  const auto opener = make_gdal_opener();
  const auto forward = opener->open_elevation(path), shared = opener->open_elevation(path);
  std::vector<RasterBlock> expected;
  for (uint32_t k = 0; k < forward->reductions(); ++k) expected.push_back(read_all(*forward, k));
  std::vector<std::thread> threads;
  std::array<int, 4> differences{};
  for (size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (size_t step = 0; step < expected.size(); ++step) {
        const size_t k = (expected.size() - 1 - step + t) % expected.size();  // coarse first, each thread its own order
        const RasterBlock all = read_all(*shared, static_cast<uint32_t>(k));
        differences[t] += all.values != expected[k].values || all.valid != expected[k].valid ? 1 : 0;
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(differences == std::array<int, 4>{});
}
