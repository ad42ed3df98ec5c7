// Files made by others. Bounds are those of gdalinfo 3.6.2, values those of gdallocationinfo.
#include <doctest/doctest.h>

#include <cstdlib>

#include "base/error.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// $NEPHO_SHARED, else ../shared beside the checkout; empty (with a message) where neither is there.
std::filesystem::path shared_data() {
  const char* set = std::getenv("NEPHO_SHARED");
  const std::filesystem::path path =
      (set ? std::filesystem::path(set) : std::filesystem::path(NEPHO_SOURCE_DIR).parent_path() / "shared") / "data";
  if (std::filesystem::is_directory(path)) return path;
  MESSAGE("skipped: no " << path.string() << "; set NEPHO_SHARED to the folder that holds data/");
  return {};
}

void check_bounds(const RasterInfo& info, double west, double south, double east, double north, double tolerance) {
  CHECK(std::abs(info.bounds.west_deg - west) < tolerance);
  CHECK(std::abs(info.bounds.south_deg - south) < tolerance);
  CHECK(std::abs(info.bounds.east_deg - east) < tolerance);
  CHECK(std::abs(info.bounds.north_deg - north) < tolerance);
}

}  // namespace

TEST_CASE("real data: elevation tiles have the bounds and heights that GDAL gives") {
  const auto data = shared_data();
  if (data.empty()) return;
  const auto opener = make_gdal_opener();
  const auto fuji = opener->open_elevation((data / "dem/mt_fuji_90m.tif").string());
  CHECK(fuji->info().width == 1201);
  check_bounds(fuji->info(), 137.99958333, 34.99958333, 139.00041667, 36.00041667, 1e-8);
  CHECK(values_at(*fuji, 138.7275, 35.3625) == std::vector<float>{3703});
  CHECK(values_at(*fuji, 138.0, 36.0) == std::vector<float>{963});
  CHECK(values_at(*fuji, 138.25, 35.5) == std::vector<float>{1531});
  CHECK(fuji->info().vertical == VerticalDatum::egm96);

  const auto alps = opener->open_elevation((data / "dem/N46E008_swiss_alps.tif").string());
  check_bounds(alps->info(), 7.99958333, 45.99958333, 9.00041667, 47.00041667, 1e-8);
  CHECK(values_at(*alps, 8.5, 46.25) == std::vector<float>{2157});
  CHECK(values_at(*alps, 8.1256, 46.5372).empty());  // nodata -32767

  const auto pyrenees = opener->open_elevation((data / "dem/N42E001.hgt").string());
  check_bounds(pyrenees->info(), 0.99958333, 41.99958333, 2.00041667, 43.00041667, 1e-8);
  CHECK(values_at(*pyrenees, 1.5, 42.5) == std::vector<float>{1095});
  CHECK(values_at(*pyrenees, 1.0, 43.0) == std::vector<float>{838});
}

TEST_CASE("real data: pictures have the bounds and colours that GDAL gives") {
  const auto data = shared_data();
  if (data.empty()) return;
  const auto opener = make_gdal_opener();
  const auto world = opener->open_imagery((data / "imagery/world_bluemarble_2048.tif").string());
  check_bounds(world->info(), -180, -90, 180, 90, 1e-9);
  CHECK(world->info().wraps);
  CHECK(values_at(*world, 30, 25) == std::vector<float>{250, 221, 161, 255});
  CHECK(values_at(*world, -60, -5) == std::vector<float>{45, 76, 16, 255});

  const auto boston = opener->open_imagery((data / "imagery/boston-inset-wgs84.tif").string());
  check_bounds(boston->info(), -71.4984181, 42.0356721, -70.6350756, 42.6143149, 1e-7);
  CHECK(values_at(*boston, -71.06, 42.36) == std::vector<float>{39, 40, 51, 255});

  StderrCapture capture;
  const std::string mask_path = (data / "imagery/watermask_august_8192.jpg").string();
  const auto water = opener->open_imagery(mask_path);
  const std::string said = capture.text();
  CHECK(said.find("nepho: warning: " + mask_path) == 0);
  CHECK(said.find('\n') == said.size() - 1);
  check_bounds(water->info(), -180, -90, 180, 90, 1e-9);
  CHECK(water->read_block(0, 16, 8)->values[0] == 253.0f);  // column 4096, row 2048
  CHECK(water->read_block(0, 18, 5)->values[(size_t{1500 - 1280} * 256 + 4800 - 4608) * 4] == 0.0f);

  CHECK(
      message_of([&] { opener->open_imagery((data / "imagery/bluemarble_xyz/0/0/0.jpg").string()); }, ErrorKind::input)
          .find("256 x 256 pixels without georeference") != std::string::npos);
}

TEST_CASE("real data: UTM and Mercator pictures land where they belong") {
  const auto data = shared_data();
  if (data.empty()) return;
  const auto opener = make_gdal_opener();
  // gdalinfo: corners 78d57'31.14"W 25d30'21.91"N, 78d53'53.28"W 23d33'53.97"N, 76d35'57.98"W 25d33'3.15"N,
  // 76d34'29.73"W 23d36'21.41"N
  const auto bahamas = opener->open_imagery((data / "imagery/bahamas_landsat7_utm18.tif").string());
  check_bounds(bahamas->info(), -78.95865, 23.564992, -76.574925, 25.550875, 0.003);  // a pixel
  // gdalwarp -r bilinear onto the same grid (1624 x 1468, pixels half as large as the source's), exact transformer:
  // within the tolerance of ours, 0.05 px, of these.
  const auto island = values_at(*bahamas, -77.9, 24.7), sea = values_at(*bahamas, -78.5, 24.0);
  REQUIRE(island.size() == 4);
  REQUIRE(sea.size() == 4);
  const std::array<float, 4> island_gdal = {31, 47, 27, 255}, sea_gdal = {13, 57, 83, 255};
  for (size_t c = 0; c < 4; ++c) {
    CHECK(std::abs(island[c] - island_gdal[c]) <= 2.0f);
    CHECK(std::abs(sea[c] - sea_gdal[c]) <= 2.0f);
  }
  CHECK(values_at(*bahamas, -76.6, 25.5).empty());  // the collar of the scene is nodata

  const auto tiles = opener->open_imagery((data / "imagery/bluemarble_z0-3_DERIVED.mbtiles").string());
  CHECK(tiles->info().wraps);
  check_bounds(tiles->info(), -180, -85.0511576, 180, 85.0511, 1e-4);
  const auto sahara = values_at(*tiles, 25, 24), amazon = values_at(*tiles, -60, -5);
  REQUIRE(sahara.size() == 4);
  REQUIRE(amazon.size() == 4);
  CHECK(sahara[0] > sahara[2] + 40.0f);  // sand, and forest in the other hemisphere: no mirror image
  CHECK(amazon[1] > amazon[0]);
  CHECK(amazon[0] < 60.0f);

  const auto plain = opener->open_imagery((data / "imagery/plain_1.mbtiles").string());
  check_bounds(plain->info(), -180, -70.0118, 180, 85.0, 1e-3);
  CHECK(values_at(*plain, 0, 0)[0] == doctest::Approx(254).epsilon(0.01));
}

TEST_CASE("real data: files that are no single raster say what they hold") {
  const auto data = shared_data();
  if (data.empty()) return;
  const auto opener = make_gdal_opener();
  StderrCapture capture;
  const std::string goes =
      (data / "satellite/OR_ABI-L2-CMIPM1-M3C01_G16_s20171931811268_e20171931811326_c20171931811382.nc").string();
  CHECK(message_of([&] { opener->open_elevation(goes); }, ErrorKind::input)
            .find("holds several rasters; name one of them: NETCDF:") != std::string::npos);
  const std::string gfs = (data / "weather/gfs_2p5deg_2011100800_f072.grib2").string();
  CHECK(message_of([&] { opener->open_elevation(gfs); }, ErrorKind::input) ==
        gfs + ": has 344 bands, elevation has one; gdal_translate -b N takes one out");
  CHECK(capture.text().empty());
}

TEST_CASE("real data: the default Earth opens without a warning, and ETOPO5 sits on its own longitudes") {
  const DefaultEarth earth = find_default_earth();
  if (earth.elevation.empty() || earth.imagery.empty() || earth.night.empty()) {
    MESSAGE("skipped: install marble-qt-data, xplanet-images and ferret-datasets");
    return;
  }
  const auto opener = make_gdal_opener();
  StderrCapture capture;
  const auto etopo = opener->open_elevation(earth.elevation);
  const auto day = opener->open_imagery(earth.imagery);
  const auto night = opener->open_imagery(earth.night);
  CHECK(capture.text().empty());

  const RasterInfo& info = etopo->info();
  CHECK(info.width == 4320);
  CHECK(info.height == 2161);
  CHECK(info.wraps);
  // Pixels are centred on multiples of 5 arc minutes, poles included.
  check_bounds(info, -1.0 / 24, -90 - 1.0 / 24, 360 - 1.0 / 24, 90 + 1.0 / 24, 1e-6);
  // gdallocationinfo by column and row: (1043, 744) is 86 55'E 28 00'N, and so on.
  CHECK(values_at(*etopo, 1043 / 12.0, 90 - 744 / 12.0) == std::vector<float>{6096});  // at Everest
  CHECK(values_at(*etopo, 1043 / 12.0, 90 - 745 / 12.0) == std::vector<float>{5943});
  CHECK(values_at(*etopo, 1708 / 12.0, 90 - 945 / 12.0) == std::vector<float>{-9487});  // Mariana trench
  CHECK(values_at(*etopo, 0.0, 0.0) == std::vector<float>{-4876});
  CHECK(values_at(*etopo, 2519 / 12.0 - 360.0, 90 - 829 / 12.0) == std::vector<float>{-5410});  // west of 180
  CHECK(values_at(*etopo, -1 / 12.0, -90.0) == std::vector<float>{2810});                       // last column, last row
  CHECK(values_at(*etopo, 0.0, 90.0) == std::vector<float>{-4290});
  // No half-pixel shift: a quarter of a pixel to either side is still the same pixel.
  for (const double d : {-1 / 48.0, 1 / 48.0})
    CHECK(values_at(*etopo, 1043 / 12.0 + d, 28.0 + d) == std::vector<float>{6096});

  CHECK(day->info().width == 2700);
  CHECK(night->info().width == 2048);
  for (const auto& raster : {day, night}) check_bounds(raster->info(), -180, -90, 180, 90, 1e-9);
  const auto sahara = values_at(*day, 25, 24), pacific = values_at(*day, -140, 0),
             tokyo = values_at(*night, 139.7, 35.7);
  CHECK(sahara[0] > 150.0f);
  CHECK(pacific[0] < 40.0f);
  CHECK(tokyo[0] > 100.0f);
}
