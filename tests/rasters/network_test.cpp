// Rasters that are not on this machine, from servers that the tests start themselves.
#include <doctest/doctest.h>

#include <map>

#include "base/error.h"
#include "rasters/http_server.h"
#include "rasters/source_test_tools.h"

using namespace nepho;
using namespace nepho::test;
namespace fs = std::filesystem;

namespace {

/// Settings of GDAL while it lives.
class ConfigOptions {
 public:
  explicit ConfigOptions(std::map<std::string, std::string> options) : options_(std::move(options)) {
    for (const auto& [name, value] : options_) CPLSetConfigOption(name.c_str(), value.c_str());
  }
  ~ConfigOptions() {
    for (const auto& [name, value] : options_) CPLSetConfigOption(name.c_str(), nullptr);
  }
  ConfigOptions(const ConfigOptions&) = delete;
  ConfigOptions& operator=(const ConfigOptions&) = delete;

 private:
  std::map<std::string, std::string> options_;
};

}  // namespace

TEST_CASE("formats: /vsicurl/ and GDAL's descriptions of tile services work over the network") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0, 300);
  recipe.value = [](int, int x, int y) { return x + y; };
  const std::string tif = make_raster(folder / "a.tif", recipe);
  RasterRecipe tile{.width = 256,
                    .height = 256,
                    .bands = 3,
                    .type = GDT_Byte,
                    .value = [](int b, int, int) { return 40 + b; },
                    .driver = "PNG"};
  make_raster(folder / "tile.png", tile);
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    if (path == "/a.tif") return {.body = bytes_of(tif)};
    if (path.starts_with("/t/")) return {.body = bytes_of(folder / "tile.png")};
    return {.status = 404};
  });
  const auto raster = elevation("/vsicurl/" + server.url() + "/a.tif");
  CHECK(read_all(*raster).values == read_all(*elevation(tif)).values);
  CHECK(raster->info().fingerprint.find("180") != std::string::npos);  // the size of the file is part of it
  CHECK(message_of([&] { elevation("/vsicurl/" + server.url() + "/none.tif"); }, ErrorKind::input)
            .find("does not exist") != std::string::npos);
  const std::string service =
      "<GDAL_WMS><Service name=\"TMS\"><ServerUrl>" + server.url() +
      "/t/${z}/${x}/${y}.png</ServerUrl></Service><DataWindow>"
      "<UpperLeftX>-20037508.34</UpperLeftX><UpperLeftY>20037508.34</UpperLeftY>"
      "<LowerRightX>20037508.34</LowerRightX><LowerRightY>-20037508.34</LowerRightY>"
      "<TileLevel>3</TileLevel><YOrigin>top</YOrigin></DataWindow><Projection>EPSG:3857</Projection>"
      "<BlockSizeX>256</BlockSizeX><BlockSizeY>256</BlockSizeY><BandsCount>3</BandsCount></GDAL_WMS>";
  for (const std::string& name : {service, [&] {
                                    std::ofstream(folder / "service.xml") << service;
                                    return (folder / "service.xml").string();
                                  }()}) {
    const auto tiles = imagery(name);
    CHECK(values_at(*tiles, 50, 30) == std::vector<float>{40, 41, 42, 255});
    CHECK(tiles->pyramid_level(tiles->reductions() - 1) > 0);
  }
}

TEST_CASE("formats: files and folders in a bucket are read through /vsis3/") {
  const TempFolder folder;
  RasterRecipe recipe = square(10, 45, 0, 300);
  recipe.value = [](int, int x, int y) { return x + y; };
  const std::string tif = make_raster(folder / "a.tif", recipe);
  const std::string far = make_raster(folder / "b.tif", square(50, 45, 321));
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    if (path == "/bucket/dem/a.tif") return {.body = bytes_of(tif)};
    if (path == "/bucket/dem/b.tif") return {.body = bytes_of(far)};
    if (!path.starts_with("/bucket/?") || path.find("prefix=dem%2F&") == std::string::npos)
      if (!path.ends_with("prefix=dem%2F")) return {.status = 404};
    std::string list = "<?xml version=\"1.0\"?><ListBucketResult><Name>bucket</Name><Prefix>dem/</Prefix>";
    for (const std::string& file : {tif, far})
      list += "<Contents><Key>dem/" + fs::path(file).filename().string() +
              "</Key><LastModified>2026-01-01T00:00:00.000Z</LastModified><Size>" +
              std::to_string(fs::file_size(file)) + "</Size></Contents>";
    return {.body = list + "<IsTruncated>false</IsTruncated></ListBucketResult>"};
  });
  const std::string endpoint = server.url().substr(std::string("http://").size());
  const ConfigOptions options({{"AWS_S3_ENDPOINT", endpoint},
                               {"AWS_HTTPS", "NO"},
                               {"AWS_VIRTUAL_HOSTING", "FALSE"},
                               {"AWS_NO_SIGN_REQUEST", "YES"}});
  const auto raster = elevation("/vsis3/bucket/dem/a.tif");
  CHECK(read_all(*raster).values == read_all(*elevation(tif)).values);
  CHECK(raster->info().fingerprint.find(std::to_string(fs::file_size(tif))) != std::string::npos);
  CHECK(message_of([&] { elevation("/vsis3/bucket/dem/none.tif"); }, ErrorKind::input)
            .find("/vsis3/bucket/dem/none.tif: ") == 0);
  const auto parts = make_gdal_opener()->open_elevation_parts("/vsis3/bucket/dem", {});
  REQUIRE(parts.size() == 2);
  CHECK(values_at(*parts[0], 10.5, 45.5) == values_at(*raster, 10.5, 45.5));
  CHECK(values_at(*parts[1], 50.5, 45.5) == std::vector<float>{321});
}

TEST_CASE("formats: a WMTS is read by its capabilities, the zoom that is looked at only") {
  const TempFolder folder;
  for (int zoom = 0; zoom < 4; ++zoom)
    make_raster(folder / ("tile" + std::to_string(zoom) + ".png"),
                {.width = 256,
                 .height = 256,
                 .bands = 3,
                 .type = GDT_Byte,
                 .value = [zoom](int b, int, int) { return 40 * zoom + b; },
                 .driver = "PNG"});
  const HttpServer server([&](const std::string& path) -> HttpServer::Answer {
    if (!path.starts_with("/wmts/")) return {.status = 404};
    return {.body = bytes_of(folder / ("tile" + path.substr(6, 1) + ".png"))};
  });
  std::string matrices;
  for (int zoom = 0; zoom < 4; ++zoom)
    matrices += fmt::format(
        "<TileMatrix><ows:Identifier>{}</ows:Identifier><ScaleDenominator>{:.12f}</ScaleDenominator>"
        "<TopLeftCorner>-20037508.342789244 20037508.342789244</TopLeftCorner><TileWidth>256</TileWidth>"
        "<TileHeight>256</TileHeight><MatrixWidth>{}</MatrixWidth><MatrixHeight>{}</MatrixHeight></TileMatrix>",
        zoom, 559082264.0287178 / (1 << zoom), 1 << zoom, 1 << zoom);
  const std::string file = (folder / "capabilities.xml").string();
  std::ofstream(file)
      << "<?xml version=\"1.0\"?><Capabilities xmlns=\"http://www.opengis.net/wmts/1.0\" "
         "xmlns:ows=\"http://www.opengis.net/ows/1.1\" version=\"1.0.0\"><Contents><Layer><ows:Identifier>ground"
         "</ows:Identifier><Style isDefault=\"true\"><ows:Identifier>default</ows:Identifier></Style>"
         "<Format>image/png</Format><TileMatrixSetLink><TileMatrixSet>mercator</TileMatrixSet></TileMatrixSetLink>"
         "<ResourceURL format=\"image/png\" resourceType=\"tile\" template=\""
      << server.url()
      << "/wmts/{TileMatrix}/{TileCol}/{TileRow}.png\"/></Layer><TileMatrixSet><ows:Identifier>mercator</"
         "ows:Identifier>"
         "<ows:SupportedCRS>urn:ogc:def:crs:EPSG::3857</ows:SupportedCRS>"
      << matrices << "</TileMatrixSet></Contents></Capabilities>";
  for (const std::string& name : {"WMTS:" + file + ",layer=ground", file}) {
    CAPTURE(name);
    const auto tiles = imagery(name);
    CHECK(values_at(*tiles, 50, 30) == std::vector<float>{120, 121, 122, 255});
    const uint32_t last = tiles->reductions() - 1;
    CHECK(tiles->pyramid_level(last) > 0);
    const size_t asked = server.asked().size();
    const RasterBlock whole = read_all(*tiles, last);
    const size_t middle = 4 * (size_t{whole.height / 2} * whole.width + whole.width / 2);
    CHECK(whole.values[middle] < 120.0f);
    CHECK(server.asked().size() - asked < 16);
  }
  CHECK_FALSE(fs::exists("gdalwmscache"));
}

TEST_CASE("bad input: a server that says nothing fails after the timeout") {
  const HttpServer server([](const std::string&) -> HttpServer::Answer { return {.silent = true}; });
  const std::string name = "/vsicurl/" + server.url() + "/a.tif";
  CHECK(message_of([&] { elevation(name, {.timeout_s = 0.3}); }, ErrorKind::input).find(name) == 0);
}
