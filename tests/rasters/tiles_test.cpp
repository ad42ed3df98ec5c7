// Tiles: folders and URLs of XYZ and TMS, Web Mercator and longitude/latitude, pictures and heights.
#include <doctest/doctest.h>

#include <barrier>
#include <chrono>
#include <future>
#include <numbers>

#include "base/error.h"
#include "rasters/gdal_opener.h"
#include "rasters/http_server.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;
namespace fs = std::filesystem;

namespace {

/// A tile whose every pixel has these numbers.
void write_tile(const fs::path& path, std::vector<int> bands, int side = 256) {
  fs::create_directories(path.parent_path());
  make_raster(path, {.width = side,
                     .height = side,
                     .bands = static_cast<int>(bands.size()),
                     .type = GDT_Byte,
                     .value = [&](int b, int, int) { return bands[static_cast<size_t>(b)]; },
                     .driver = "PNG"});
}

/// Zooms 0..2 of the whole Earth: red is the zoom, green the column, blue the row from the north.
void write_world(const fs::path& folder, bool rows_from_south = false, int side = 256) {
  for (int z = 0; z <= 2; ++z)
    for (int x = 0; x < 1 << z; ++x)
      for (int y = 0; y < 1 << z; ++y)
        write_tile(folder / std::to_string(z) / std::to_string(x) /
                       (std::to_string(rows_from_south ? (1 << z) - 1 - y : y) + ".png"),
                   {100 + z, 10 * x, 10 * y}, side);
}

/// Row of Web Mercator tiles that a latitude lies in: (1 - asinh(tan(lat)) / pi) / 2 of the way down (OSM wiki).
int mercator_row(double lat_deg, int zoom) {
  const double lat = lat_deg * std::numbers::pi / 180.0;
  return static_cast<int>((1.0 - std::asinh(std::tan(lat)) / std::numbers::pi) / 2.0 * (1 << zoom));
}

struct Place {
  double lon, lat;
};
// None within a tenth of a tile of another one.
constexpr Place kPlaces[] = {{-170, 80}, {-100, 50}, {-30, 20}, {30, -20}, {100, -50}, {160, -75}, {50, 40}};

void check_world(const Raster& raster) {
  for (const auto& [lon, lat] : kPlaces) {
    CAPTURE(lon);
    CAPTURE(lat);
    const float column = static_cast<float>(10 * static_cast<int>((lon + 180.0) / 90.0));
    const float row = static_cast<float>(10 * mercator_row(lat, 2));
    CHECK(values_at(raster, lon, lat) == std::vector<float>{102, column, row, 255});
  }
}

std::shared_ptr<Raster> imagery(const std::string& path, const RasterReading& how = {}) {
  return make_gdal_opener()->open_imagery(path, how);
}

}  // namespace

TEST_CASE("tiles: a folder of XYZ tiles is a source by itself, named by folder or by template") {
  const TempFolder folder;
  write_world(folder / "tiles");
  for (const std::string& name :
       {(folder / "tiles").string(), (folder / "tiles").string() + "/", (folder / "tiles/{z}/{x}/{y}.png").string()}) {
    CAPTURE(name);
    StderrCapture capture;
    const auto raster = imagery(name);
    CHECK(capture.text().empty());
    CHECK(raster->info().path == name);
    CHECK(raster->info().wraps);
    CHECK(raster->info().width == 2 * 1024);  // warped to half the pixel
    CHECK(raster->info().oversampling == 2.0);
    CHECK(std::abs(raster->info().bounds.north_deg - 85.0511288) < 1e-6);
    CHECK(std::abs(raster->info().bounds.south_deg + 85.0511288) < 1e-6);
    check_world(*raster);
  }
}

TEST_CASE("tiles: rows from the south are TMS: {-y}, or a folder that gdal2tiles made") {
  const TempFolder folder;
  write_world(folder / "tms", true);
  check_world(*imagery((folder / "tms/{z}/{x}/{-y}.png").string()));
  std::ofstream(folder / "tms/tilemapresource.xml")
      << "<TileMap><SRS>EPSG:3857</SRS><TileSets profile=\"mercator\"/></TileMap>";
  check_world(*imagery((folder / "tms").string()));
}

TEST_CASE("tiles: tiles of 512 px are twice as fine, and other layouts of names are found") {
  const TempFolder folder;
  write_world(folder / "big", false, 512);
  const auto big = imagery((folder / "big").string());
  CHECK(big->info().width == 2 * 2048);
  check_world(*big);
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      write_tile(folder / ("flat/1_" + std::to_string(y) + "_" + std::to_string(x) + "@2.png"), {7, x, y});
  const auto flat = imagery((folder / "flat/{z}_{y}_{x}@2.png").string());
  CHECK(flat->info().width == 2 * 512);
  CHECK(values_at(*flat, 90, -45) == std::vector<float>{7, 1, 1, 255});
}

TEST_CASE("tiles: a geodetic folder of gdal2tiles has two tiles at zoom 0") {
  const TempFolder folder;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y)
      write_tile(folder / ("g/1/" + std::to_string(x) + "/" + std::to_string(y) + ".png"), {x, y, 0});
  for (int x = 0; x < 2; ++x) write_tile(folder / ("g/0/" + std::to_string(x) + "/0.png"), {50 + x, 0, 0});
  std::ofstream(folder / "g/tilemapresource.xml") << "<TileMap><SRS>EPSG:4326</SRS></TileMap>";
  const auto raster = imagery((folder / "g").string());
  CHECK(raster->info().width == 1024);
  CHECK(raster->info().height == 512);
  CHECK(values_at(*raster, -100, -20) == std::vector<float>{0, 0, 0, 255});  // rows from the south
  CHECK(values_at(*raster, 100, 20) == std::vector<float>{3, 1, 0, 255});
  CHECK(raster->read_block(1, 1, 0)->values[0] == 51.0f);  // zoom 0
}

TEST_CASE("tiles: reductions come from the coarser zooms, and zooms can be limited") {
  const TempFolder folder;
  write_world(folder / "tiles");
  const auto raster = imagery((folder / "tiles").string());
  for (uint32_t k = 0; k <= 3; ++k) {
    CAPTURE(k);
    CHECK(raster->pyramid_level(k) == k);
    CHECK(raster->read_block(k, 0, 0)->values[4 * (100 * raster->read_block(k, 0, 0)->width + 100)] ==
          102.0f - static_cast<float>(std::max(k, 1u) - 1));
  }
  const auto coarse = imagery((folder / "tiles").string(), {.max_zoom = 1});
  CHECK(coarse->info().width == 2 * 512);
  CHECK(values_at(*coarse, 90, -45) == std::vector<float>{101, 10, 10, 255});
  const auto fine = imagery((folder / "tiles").string(), {.min_zoom = 2});
  CHECK(fine->read_block(2, 0, 0)->values[4 * (100 * fine->read_block(2, 0, 0)->width + 100)] == 102.0f);
  CHECK(message_of([&] { imagery((folder / "tiles").string(), {.min_zoom = 3}); }, ErrorKind::input) ==
        (folder / "tiles").string() + ": no tiles found between min_zoom and max_zoom");
}

TEST_CASE("tiles: a missing tile or zoom is covered by the nearest coarser one that is there") {
  const TempFolder folder;
  write_world(folder / "t");
  fs::remove(folder / "t/2/1/1.png");
  fs::remove_all(folder / "t/1");
  // A picture of four colours, to see which part of it is taken.
  make_raster(folder / "t/0/0/0.png",
              {.width = 256,
               .height = 256,
               .bands = 3,
               .type = GDT_Byte,
               .value = [](int b, int x, int y) { return b == 0   ? 50
                                                         : b == 1 ? x / 64
                                                                  : y / 64; },
               .driver = "PNG"});
  const auto raster = imagery((folder / "t").string());
  CHECK(values_at(*raster, -45, 20) == std::vector<float>{50, 1, 1, 255});
  CHECK(values_at(*raster, 45, 20) == std::vector<float>{102, 20, 10, 255});
  // Zoom 1 is not there at all: what stands for it is the mean of zoom 2, and not the coarser zoom 0.
  const RasterBlock coarse = *raster->read_block(2, 1, 1);
  CHECK(coarse.values[4 * (40 * coarse.width + 40)] == 102.0f);
}

TEST_CASE("tiles: without coarser zooms a missing tile is a hole, and a few tiles bound the raster") {
  const TempFolder folder;
  write_tile(folder / "t/4/8/5.png", {1, 2, 3});
  write_tile(folder / "t/4/10/6.png", {4, 5, 6});
  const auto raster = imagery((folder / "t").string());
  CHECK_FALSE(raster->info().wraps);
  const LonLatBounds& b = raster->info().bounds;
  CHECK(b.west_deg == doctest::Approx(0.0));
  CHECK(b.east_deg == doctest::Approx(67.5));
  CHECK(values_at(*raster, 11, 50) == std::vector<float>{1, 2, 3, 255});
  CHECK(values_at(*raster, 55, 30) == std::vector<float>{4, 5, 6, 255});
  CHECK(values_at(*raster, 33, 50).empty());
  CHECK(values_at(*raster, 11, 30).empty());
}

TEST_CASE("tiles: transparent, grey and palette tiles count as in pictures") {
  const TempFolder folder;
  write_tile(folder / "t/1/0/0.png", {1, 2, 3, 0});
  write_tile(folder / "t/1/0/1.png", {10, 20, 30, 51});
  write_tile(folder / "t/1/1/0.png", {77});
  fs::create_directories(folder / "t/1/1");
  make_raster(folder / "t/1/1/1.png", {.width = 256,
                                       .height = 256,
                                       .type = GDT_Byte,
                                       .value = [](int, int, int) { return 3; },
                                       .finish =
                                           [](GDALDataset& d) {
                                             GDALColorTable colours;
                                             const GDALColorEntry red{250, 10, 20, 255};
                                             colours.SetColorEntry(3, &red);
                                             REQUIRE(d.GetRasterBand(1)->SetColorTable(&colours) == CE_None);
                                           },
                                       .driver = "PNG"});
  const auto raster = imagery((folder / "t").string());
  CHECK(values_at(*raster, -90, 45).empty());
  CHECK(values_at(*raster, -90, -45) == std::vector<float>{10, 20, 30, 51});
  CHECK(values_at(*raster, 90, 45) == std::vector<float>{77, 77, 77, 255});
  CHECK(values_at(*raster, 90, -45) == std::vector<float>{250, 10, 20, 255});
}

TEST_CASE("tiles: heights in colours are read as metres, recognised by their numbers or told") {
  const TempFolder folder;
  // Terrarium: 256 R + G + B / 256 - 32768. Mapbox: 0.1 (65536 R + 256 G + B) - 10000.
  const struct {
    const char* name;
    std::vector<int> high, low;
    float high_m, low_m;
  } codes[] = {{"terrarium", {142, 128, 64}, {127, 246, 0}, 3712.25f, -10.0f},
               {"mapbox", {2, 23, 80}, {1, 134, 60}, 3704.0f, -10.0f}};
  for (const auto& code : codes) {
    CAPTURE(code.name);
    const fs::path tiles = folder / (std::string("code_") + code.name[0]);  // says nothing
    for (int x = 0; x < 2; ++x)
      for (int y = 0; y < 2; ++y)
        if (x + y < 2)
          write_tile(tiles / ("1/" + std::to_string(x) + "/" + std::to_string(y) + ".png"), x ? code.high : code.low);
    for (const std::string encoding : {"auto", code.name}) {
      CAPTURE(encoding);
      const auto raster = make_gdal_opener()->open_elevation(tiles.string(), {.encoding = encoding});
      CHECK(raster->info().bands == 1);
      REQUIRE(values_at(*raster, 90, 45).size() == 1);
      CHECK(values_at(*raster, 90, 45)[0] == doctest::Approx(code.high_m).epsilon(1e-6));
      CHECK(values_at(*raster, -90, -45)[0] == doctest::Approx(code.low_m).epsilon(1e-6));
      CHECK(values_at(*raster, 90, -45).empty());  // the missing tile
    }
    CHECK(
        message_of([&] { make_gdal_opener()->open_elevation(tiles.string(), {.encoding = "none"}); }, ErrorKind::input)
            .find("has 4 bands, elevation has one") != std::string::npos);
  }
}

TEST_CASE("tiles: tiles of plain heights are elevation as they are") {
  const TempFolder folder;
  fs::create_directories(folder / "t/0/0");
  make_raster(folder / "t/0/0/0.tif", {.width = 256,
                                       .height = 256,
                                       .type = GDT_Int16,
                                       .value = [](int, int x, int) { return x < 128 ? 1234 : -9999; },
                                       .finish = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-9999); }});
  const auto raster = make_gdal_opener()->open_elevation((folder / "t").string());
  CHECK(values_at(*raster, -90, 10) == std::vector<float>{1234});
  CHECK(values_at(*raster, 90, 10).empty());
}

TEST_CASE(
    "tiles: a URL template asks a server; what it lacks comes from coarser zooms, and its failures fail the block") {
  const TempFolder folder;
  write_world(folder / "tiles");
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    if (path == "/2/1/1.png") return {.status = 404, .body = "no such tile"};
    if (path == "/2/3/3.png") return {.status = 500, .body = "out of order"};
    const fs::path file = folder / ("tiles" + path);
    if (!fs::exists(file)) return {.status = 404};
    return {.body = bytes_of(file)};
  });
  const std::string name = server.url() + "/{z}/{x}/{y}.png";
  const auto raster = imagery(name, {.max_zoom = 2});
  CHECK(raster->info().width == 2 * 1024);
  CHECK(values_at(*raster, 30, 20) == std::vector<float>{102, 20, 10, 255});
  CHECK(values_at(*raster, -45, 20) == std::vector<float>{101, 0, 0, 255});  // of zoom 1
  const auto broken = raster->read_block(0, 7, (raster->info().height - 1) / 256);
  REQUIRE_FALSE(broken);
  CHECK(broken.reason().find(name) == 0);
  CHECK(broken.reason().find("500") != std::string::npos);
  const size_t before = server.asked().size();
  CHECK(raster->read_block(3, 0, 0)->values[4 * (100 * raster->read_block(3, 0, 0)->width + 100)] == 100.0f);
  CHECK(server.asked().size() <= before + 1);  // zoom 0 and nothing else
}

TEST_CASE("tiles: a service of the whole Earth in 20 zooms is one raster, and a look at it asks for a few tiles only") {
  const TempFolder folder;
  write_tile(folder / "a.png", {10, 20, 30});
  const HttpServer server(
      [&](const std::string&) -> HttpServer::Answer { return {.body = bytes_of(folder / "a.png")}; });
  const auto raster = imagery(server.url() + "/{z}/{x}/{-y}");
  CHECK(raster->info().width == 256u << 20);
  CHECK(values_at(*raster, 138.7275, 35.3625) == std::vector<float>{10, 20, 30, 255});
  const uint32_t last = raster->reductions() - 1;
  CHECK(raster->read_block(last, 0, 0)->values[0] == 10.0f);
  CHECK(server.asked().size() < 20);
  const auto heights = make_gdal_opener()->open_elevation(server.url() + "/{z}/{x}/{y}.png", {.encoding = "terrarium"});
  CHECK(heights->info().width == 256u << 15);
}

TEST_CASE("tiles: a server that hangs fails after the timeout, at the start and later") {
  const TempFolder folder;
  write_world(folder / "tiles");
  std::atomic<bool> silent{true};
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    const fs::path file = folder / ("tiles" + path);
    if (!fs::exists(file)) return {.status = 404};
    return {.body = bytes_of(file), .silent = silent};
  });
  const std::string name = server.url() + "/{z}/{x}/{y}.png";
  CHECK(message_of([&] { imagery(name, {.max_zoom = 2, .timeout_s = 0.5}); }, ErrorKind::input)
            .find(name + ": its tile ") == 0);
  silent = false;
  const auto raster = imagery(name, {.max_zoom = 2, .timeout_s = 0.5});
  silent = true;
  const auto block = raster->read_block(0, 2, 2);
  REQUIRE_FALSE(block);
  CHECK(block.reason().find("timed out") != std::string::npos);
}

TEST_CASE("tiles: several threads read one source together") {
  if (std::thread::hardware_concurrency() < 2) {
    MESSAGE("skipped: one core");
    return;
  }
  const TempFolder folder;
  write_world(folder / "tiles");
  // A tile of the finest zoom is given out only while another one is asked for, too.
  std::atomic<int> waiting{0};
  std::atomic<bool> together{false};
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    const fs::path file = folder / ("tiles" + path);
    if (!fs::exists(file)) return {.status = 404};
    if (path.starts_with("/2/")) {
      if (++waiting >= 2) together = true;
      for (int i = 0; i < 500 && !together; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return {.body = bytes_of(file)};
  });
  const auto raster = imagery(server.url() + "/{z}/{x}/{y}.png", {.max_zoom = 2});
  const auto west = std::async(std::launch::async, [&] { return raster->read_block(0, 0, 0); });
  const auto east = raster->read_block(0, 3, 0);
  west.wait();
  CHECK(together);
  CHECK(static_cast<bool>(east));
}

TEST_CASE("bad input: tiles that are none") {
  const TempFolder folder;
  fs::create_directories(folder / "t/0/0");
  std::ofstream(folder / "t/0/0/0.png") << "no picture";
  const std::string name = (folder / "t").string();
  CHECK(message_of([&] { imagery(name); }, ErrorKind::input).find(name + ": its tile ") == 0);
  CHECK(message_of([&] { imagery(name + "/{z}/{x}/{y}.jpg"); }, ErrorKind::input) ==
        name + "/{z}/{x}/{y}.jpg: no tiles found");
  write_tile(folder / "u/0/0/0.png", {1, 2, 3});
  std::ofstream(folder / "u/0/0/0.png") << "";
  CHECK(message_of([&] { imagery((folder / "u").string()); }, ErrorKind::input)
            .find("is not a picture that GDAL can open") != std::string::npos);
}
