// Every bad input is Error(input), one line that starts with the file's name, and nothing else on standard error.
#include <doctest/doctest.h>

#include "base/error.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;

namespace {

enum class As { elevation, imagery };

/// Opens `path`, which must fail with `found` in its message.
void check_refused(const std::string& path, const std::string& found, As as = As::elevation) {
  CAPTURE(path);
  const auto opener = make_gdal_opener();
  StderrCapture capture;
  const std::string message = message_of(
      [&] { as == As::elevation ? opener->open_elevation(path) : opener->open_imagery(path); }, ErrorKind::input);
  CHECK(capture.text().empty());
  CHECK_MESSAGE(message.find(path + ": ") == 0, message);
  CHECK_MESSAGE(message.find(found) != std::string::npos, message);
}

RasterRecipe small(int width, int height, int bands) {
  return {.width = width, .height = height, .bands = bands, .type = GDT_Byte, .value = [](int b, int x, int y) {
            return (x * 31 + y * 17 + b) % 256;
          }};
}

/// The first bytes of a file only: too few, half of them, all but the last 16.
std::vector<std::string> cuts(const std::filesystem::path& from) {
  const std::string bytes = bytes_of(from);
  std::vector<std::string> paths;
  for (const size_t kept : {size_t{40}, bytes.size() / 2, bytes.size() - 16}) {
    paths.push_back(from.string() + "." + std::to_string(kept) + from.extension().string());
    std::ofstream(paths.back(), std::ios::binary) << bytes.substr(0, kept);
  }
  return paths;
}

}  // namespace

TEST_CASE("bad input: missing, empty, a folder, not a raster") {
  const TempFolder folder;
  check_refused((folder / "missing.tif").string(), "no such file");
  check_refused("NETCDF:\"" + (folder / "missing.nc").string() + "\":z", "is not a raster that GDAL can open");
  std::ofstream(folder / "empty.tif").flush();
  check_refused((folder / "empty.tif").string(), "is an empty file");
  std::filesystem::create_directory(folder / "none");
  check_refused((folder / "none").string(), "is a folder without rasters");
  std::ofstream(folder / "text.tif") << "heights of my garden: 1 2 3";
  check_refused((folder / "text.tif").string(), "is not a raster that GDAL can open");
  std::ofstream(folder / "vector.geojson") << R"({"type":"FeatureCollection","features":[]})";
  check_refused((folder / "vector.geojson").string(), "is not a raster that GDAL can open");
}

TEST_CASE("bad input: files that were cut off") {
  const TempFolder folder;
  RasterRecipe recipe = small(256, 128, 3);
  for (const auto& [driver, name] :
       {std::pair{"GTiff", "a.tif"}, std::pair{"PNG", "a.png"}, std::pair{"JPEG", "a.jpg"}}) {
    recipe.driver = driver;
    make_raster(folder / name, recipe);
    for (const std::string& path : cuts(folder / name)) check_refused(path, "", As::imagery);
  }
}

TEST_CASE("bad input: pixels that go missing later fail the block, not the program") {
  const TempFolder folder;
  RasterRecipe recipe = small(512, 256, 1);
  recipe.options = {"BLOCKYSIZE=16"};
  make_raster(folder / "hole.tif", recipe);
  const std::string path = (folder / "hole.tif").string();
  StderrCapture capture;
  const auto raster = make_gdal_opener()->open_elevation(path);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 4);
  const auto block = raster->read_block(0, 1, 0);
  const std::string said = capture.text();
  CHECK(said.find("no georeference") != std::string::npos);
  CHECK(said.find('\n') == said.size() - 1);
  REQUIRE_FALSE(block);
  CHECK(block.reason().find(path + ": is cut off or damaged") == 0);
}

TEST_CASE("bad input: nothing says where it lies") {
  const TempFolder folder;
  RasterRecipe recipe = small(64, 33, 1);
  check_refused(make_raster(folder / "plain.tif", recipe), "64 x 33 pixels without georeference");
  recipe.geotransform = {290000, 30, 0, 3920000, 0, -30};
  check_refused(make_raster(folder / "metres.tif", recipe), "has no CRS");
  recipe.crs = R"(LOCAL_CS["garden",UNIT["metre",1]])";
  check_refused(make_raster(folder / "garden.tif", recipe), "its CRS 'garden' is not a place on the Earth");
  recipe.crs = "EPSG:4978";
  check_refused(make_raster(folder / "geocentric.tif", recipe), "is not a place on the Earth");
}

TEST_CASE("bad input: a CRS that PROJ does not know") {
  const TempFolder folder;
  RasterRecipe recipe = small(64, 32, 1);
  make_raster(folder / "pixels.tif", recipe);
  for (const std::string srs : {"EPSG:999999", "PROJCS[&quot;broken&quot;"}) {
    std::ofstream(folder / "crs.vrt") << "<VRTDataset rasterXSize=\"64\" rasterYSize=\"32\"><SRS>" << srs
                                      << "</SRS><GeoTransform>10, 0.1, 0, 50, 0, -0.1</GeoTransform>"
                                      << "<VRTRasterBand dataType=\"Byte\" band=\"1\"><SimpleSource><SourceFilename "
                                         "relativeToVRT=\"1\">pixels.tif</SourceFilename></SimpleSource>"
                                      << "</VRTRasterBand></VRTDataset>";
    check_refused((folder / "crs.vrt").string(), "CRS");
  }
  // GeoTIFF: a projected CRS whose code nobody has given out (keys 1024 model, 1025 raster, 3072 projected).
  recipe.geotransform = {290000, 30, 0, 3920000, 0, -30};
  recipe.crs = "EPSG:32654";
  std::string bytes = bytes_of(make_raster(folder / "code.tif", recipe));
  const std::string key("\x00\x0c\x00\x00\x01\x00\x76\x7f", 8);  // 3072, in place, 1 value, 32630 + 24
  const size_t at = bytes.find(std::string("\x00\x0c\x00\x00\x01\x00\x8e\x7f", 8));
  REQUIRE(at != std::string::npos);
  bytes.replace(at + 6, 2, "\xd8\x59");  // 23000
  std::ofstream(folder / "code.tif", std::ios::binary) << bytes;
  check_refused((folder / "code.tif").string(), "CRS");
}

TEST_CASE("bad input: a CRS file beside the raster that is broken is not the same as none") {
  const TempFolder folder;
  std::ofstream(folder / "grid.asc") << "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2\n3 4\n";
  std::ofstream(folder / "grid.prj") << "PROJCS[\"nonsense";
  check_refused((folder / "grid.asc").string(), "CRS");
}

TEST_CASE("bad input: bands that make no heights or no picture") {
  const TempFolder folder;
  RasterRecipe recipe = small(64, 32, 3);
  recipe.geotransform = {10, 0.1, 0, 50, 0, -0.1};
  recipe.crs = "EPSG:4326";
  check_refused(make_raster(folder / "rgb.tif", recipe), "has 3 bands, elevation has one");
  recipe.bands = 5;
  check_refused(make_raster(folder / "five.tif", recipe), "has 5 bands", As::imagery);
  recipe.bands = 2;
  recipe.options = {"ALPHA=NO"};
  check_refused(make_raster(folder / "two.tif", recipe), "has 2 bands", As::imagery);
  recipe.options = {};
  recipe.bands = 1;
  recipe.finish = [](GDALDataset& d) {
    GDALColorTable colors;
    const GDALColorEntry red{250, 10, 20, 255};
    colors.SetColorEntry(3, &red);
    REQUIRE(d.GetRasterBand(1)->SetColorTable(&colors) == CE_None);
  };
  check_refused(make_raster(folder / "palette.tif", recipe), "is a palette picture, not elevation");
  recipe.finish = {};
  recipe.type = GDT_CFloat32;
  check_refused(make_raster(folder / "complex.tif", recipe), "holds complex numbers");
}
