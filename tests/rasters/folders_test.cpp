// Folders of rasters as one source: what is put together, and what stays apart.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "base/error.h"
#include "rasters/raster_clusters.h"
#include "rasters/source_test_tools.h"

using namespace nepho;
using namespace nepho::test;
namespace fs = std::filesystem;

TEST_CASE("folders: all rasters in a folder and below are one source, and the rest is skipped with one line") {
  const TempFolder folder;
  fs::create_directories(folder / "dem/east/deep");
  make_raster(folder / "dem/a.tif", square(10, 45, 100));
  make_raster(folder / "dem/b.tif", square(11, 45, 300));
  make_raster(folder / "dem/east/deep/c.tif", square(10, 46, 200, 40));
  make_raster(folder / "dem/z_over_b.tif", square(11.5, 45, 777));
  std::ofstream(folder / "dem/README.txt") << "heights";
  std::ofstream(folder / "dem/a.tif.aux.xml") << "<PAMDataset></PAMDataset>";
  make_raster(
      folder / "dem/preview.png",
      {.width = 20, .height = 10, .type = GDT_Byte, .value = [](int, int x, int) { return x; }, .driver = "PNG"});
  const std::string name = (folder / "dem").string();
  StderrCapture capture;
  const auto raster = elevation(name);
  const std::string said = capture.text();
  CHECK(said == "nepho: warning: " + name +
                    ": 2 of 6 files skipped, as they are no rasters, have no place or have other bands: README.txt, "
                    "...\n");
  CHECK(raster->info().path == name);
  CHECK(raster->info().bounds.west_deg == doctest::Approx(10));
  CHECK(raster->info().bounds.east_deg == doctest::Approx(12.5));
  CHECK(raster->info().bounds.north_deg == doctest::Approx(47));
  CHECK(values_at(*raster, 10.5, 45.5) == std::vector<float>{100});
  CHECK(values_at(*raster, 11.2, 45.5) == std::vector<float>{300});
  CHECK(values_at(*raster, 11.8, 45.5) == std::vector<float>{777});  // later names over earlier ones
  CHECK(values_at(*raster, 10.5, 46.5) == std::vector<float>{200});
  CHECK(values_at(*raster, 11.5, 46.5).empty());  // a gap
}

TEST_CASE("folders: rasters of several coordinate systems, resolutions and places are a part each, with its own grid") {
  const TempFolder folder;
  fs::create_directories(folder / "dem");
  make_raster(folder / "dem/a_lonlat.tif", square(10, 45, 100));
  make_raster(folder / "dem/b_far.tif", square(-150, 45, 400));
  make_raster(folder / "dem/c_fine.tif", square(10.5, 45, 300, 200));
  RasterRecipe utm = square(0, 0, 250, 100);  // zone 32: 9 degrees east is at 500 km
  utm.crs = "EPSG:32632";
  utm.geotransform = {600000, 1000, 0, 5300000, 0, -1000};  // 10.34..11.6 E, 46.9..47.8 N
  make_raster(folder / "dem/d_utm.tif", utm);
  RasterRecipe turned = square(20, 45, 500);  // 45 degrees
  turned.geotransform = {20, 0.05, 0.05, 46, 0.05, -0.05};
  make_raster(folder / "dem/e_turned.tif", turned);
  const std::string name = (folder / "dem").string();
  const auto parts = make_gdal_opener()->open_elevation_parts(name, {});
  REQUIRE(parts.size() == 5);
  for (const auto& part : parts) CHECK(part->info().path == name);
  CHECK(values_at(*parts[0], 10.5, 45.5) == std::vector<float>{100});
  CHECK(parts[0]->info().width == 20);
  CHECK(values_at(*parts[1], -149.5, 45.5) == std::vector<float>{400});
  CHECK(values_at(*parts[2], 10.7, 45.5) == std::vector<float>{300});
  CHECK(parts[2]->info().width == 200);
  REQUIRE(values_at(*parts[3], 11.0, 47.4).size() == 1);
  CHECK(values_at(*parts[3], 11.0, 47.4)[0] == doctest::Approx(250));
  CHECK(parts[3]->info().bounds.west_deg > 10.2);
  CHECK(parts[3]->info().bounds.south_deg > 46.8);
  REQUIRE(values_at(*parts[4], 21.0, 46.0).size() == 1);
  CHECK(values_at(*parts[4], 21.0, 46.0)[0] == doctest::Approx(500));
  std::set<std::string> fingerprints;
  for (const auto& part : parts) fingerprints.insert(part->info().fingerprint);
  CHECK(fingerprints.size() == 5);
  CHECK(message_of([&] { elevation(name); }, ErrorKind::input).find(name + ": its rasters make 5 grids") == 0);
}

TEST_CASE("folders: a damaged part is left out of its folder, and an only one is an error") {
  const TempFolder folder;
  fs::create_directories(folder / "dem");
  make_raster(folder / "dem/a.tif", square(10, 45, 100));
  const std::string cut = make_raster(folder / "dem/b.tif", square(50, 45, 100, 400));
  fs::resize_file(cut, fs::file_size(cut) / 2);
  StderrCapture capture;
  const auto parts = make_gdal_opener()->open_elevation_parts((folder / "dem").string(), {});
  const std::string said = capture.text();
  CHECK(parts.size() == 1);
  CHECK(said.find(cut + ": is cut off or damaged") != std::string::npos);
  CHECK(said.find("; left out of its folder\n") != std::string::npos);
  fs::remove(folder / "dem/a.tif");
  CHECK(message_of([&] { elevation((folder / "dem").string()); }, ErrorKind::input).find(cut + ": is cut off") == 0);
}

TEST_CASE("folders: tiles on both sides of the antimeridian are one part, which costs what the tiles cost") {
  const TempFolder folder;
  fs::create_directories(folder / "dem");
  for (const double lon : {-180.0, 179.0})
    make_raster(folder / ("dem/" + std::to_string(lon) + ".tif"), square(lon, 60, 500, 1200));
  const auto raster = elevation((folder / "dem").string());
  CHECK(raster->info().wraps);
  CHECK(raster->info().width == 360 * 1200);
  // At 8 x 8 pixels this is 211 times 1200 rows of 2,048 pixels; only the ends are read.
  int with_data = 0;
  for (uint32_t bx = 0; bx < 211; ++bx) {
    const Result<RasterBlock> block = raster->read_block(3, bx, 0);
    REQUIRE(static_cast<bool>(block));
    CHECK(block->values.size() == block->valid.size());
    if (std::ranges::count(block->valid, 1) == 0) continue;
    ++with_data;
    CHECK(*std::ranges::max_element(block->values) == 500.0f);
  }
  CHECK(with_data == 2);  // the east one lies on columns 430,800 to 432,000, block 210 begins at 430,080
}

TEST_CASE("folders: pictures leave gaps open, and those of 16 bits become black and white at the same numbers") {
  const TempFolder folder;
  fs::create_directories(folder / "pics");
  for (const double lon : {10.0, 11.0}) {
    RasterRecipe picture = square(lon, lon + 35, lon);  // corner to corner
    picture.bands = 3;
    picture.type = GDT_Byte;
    make_raster(folder / ("pics/" + std::to_string(lon) + ".tif"), picture);
  }
  const auto raster = imagery((folder / "pics").string());
  CHECK(values_at(*raster, 10.5, 45.5) == std::vector<float>{10, 10, 10, 255});
  CHECK(values_at(*raster, 11.5, 46.5) == std::vector<float>{11, 11, 11, 255});
  CHECK(values_at(*raster, 11.5, 45.5).empty());
  fs::create_directories(folder / "deep");
  for (const double lon : {10.0, 40.0}) {
    RasterRecipe picture = square(lon, 45, 0);
    picture.type = GDT_UInt16;
    picture.value = [lon](int, int x, int) { return 100 * lon + 10 * x; };  // 1000..1190 and 4000..4190
    make_raster(folder / ("deep/" + std::to_string(lon) + ".tif"), picture);
  }
  const auto parts = make_gdal_opener()->open_imagery_parts((folder / "deep").string(), {});
  REQUIRE(parts.size() == 2);
  CHECK(values_at(*parts[0], 10.01, 45.5)[0] == 0.0f);
  CHECK(values_at(*parts[0], 10.99, 45.5)[0] == doctest::Approx(255.0 * 190 / 3190).epsilon(0.01));
  CHECK(values_at(*parts[1], 40.01, 45.5)[0] == doctest::Approx(255.0 * 3000 / 3190).epsilon(0.01));
  CHECK(values_at(*parts[1], 40.99, 45.5)[0] == doctest::Approx(255.0));
}

TEST_CASE("clusters: what touches and is of like resolution, and not more than 64") {
  const auto tile = [](double west, double south, double step = 0.1) {
    return ClusterTile{west, south, west + 1, south + 1, step, step};
  };
  using Clusters = std::vector<std::vector<size_t>>;
  const std::vector<ClusterTile> tiles = {tile(0, 0),       tile(5, 5),   tile(1, 1),   tile(1.2, 2.14), tile(2.4, 3.3),
                                          tile(0, 0, 0.01), tile(178, 0), tile(179, 0), tile(-180, 0)};
  CHECK(cluster_tiles(tiles, 360.0) == Clusters{{0, 2, 3}, {1}, {4}, {5}, {6, 7, 8}});
  CHECK(cluster_tiles(tiles, 0.0) == Clusters{{0, 2, 3}, {1}, {4}, {5}, {6, 7}, {8}});
  CHECK(cluster_tiles({}, 0.0).empty());
  std::vector<ClusterTile> islands;
  for (int i = 0; i < 900; ++i) islands.push_back(tile(3 * (i % 30), 3 * (i / 30)));
  const Clusters joined = cluster_tiles(islands, 0.0);
  CHECK(joined.size() <= 64);
  CHECK(joined.size() >= 16);
  size_t count = 0;
  for (const auto& members : joined) count += members.size();
  CHECK(count == 900);
}
