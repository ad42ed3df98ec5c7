// Every raster of the real data, opened with nothing but its path, against GDAL's own reading of the file there.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"

using namespace nepho;
using namespace nepho::test;
namespace fs = std::filesystem;

namespace {

fs::path shared_data() {
  const char* set = std::getenv("NEPHO_SHARED");
  const fs::path path = (set ? fs::path(set) : fs::path(NEPHO_SOURCE_DIR).parent_path() / "shared") / "data";
  if (fs::is_directory(path)) return path;
  MESSAGE("skipped: no " << path.string() << "; set NEPHO_SHARED to the folder that holds data/");
  return {};
}

/// A file read as gdallocationinfo -wgs84 does: longitude and latitude through the CRS and the inverse geotransform to
/// a pixel. Pictures that nothing places are the whole globe.
class FileByGdal {
 public:
  explicit FileByGdal(const std::string& path) {
    GDALAllRegister();
    dataset_.reset(GDALDataset::Open(path.c_str()));
    REQUIRE(dataset_ != nullptr);
    if (dataset_->GetGeoTransform(from_pixel_.data()) != CE_None)
      from_pixel_ = {-180, 360.0 / dataset_->GetRasterXSize(), 0, 90, 0, -180.0 / dataset_->GetRasterYSize()};
    REQUIRE(GDALInvGeoTransform(from_pixel_.data(), to_pixel_.data()));
    const OGRSpatialReference lon_lat = srs_of("EPSG:4326");
    if (const OGRSpatialReference* srs = dataset_->GetSpatialRef()) {
      OGRSpatialReference own(*srs);
      own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
      to_own_.reset(OGRCreateCoordinateTransformation(&lon_lat, &own));
    }
  }
  /// Fractional column and row.
  std::array<double, 2> pixel(double lon, double lat) const {
    double x = lon, y = lat;
    if (to_own_) REQUIRE(to_own_->Transform(1, &x, &y));
    return {to_pixel_[0] + to_pixel_[1] * x + to_pixel_[2] * y, to_pixel_[3] + to_pixel_[4] * x + to_pixel_[5] * y};
  }
  bool inside(int column, int row) const {
    return column >= 0 && row >= 0 && column < dataset_->GetRasterXSize() && row < dataset_->GetRasterYSize();
  }
  /// Grey is given three times.
  double value(int band, int column, int row) const {
    double v = 0.0;
    GDALRasterBand* b = dataset_->GetRasterBand(std::min(band, dataset_->GetRasterCount() >= 3 ? 4 : 1));
    REQUIRE(b->RasterIO(GF_Read, column, row, 1, 1, &v, 1, 1, GDT_Float64, 0, 0, nullptr) == CE_None);
    return v;
  }
  bool valid(int column, int row) const {
    uint8_t mask = 0;
    GDALRasterBand* b = dataset_->GetRasterBand(1)->GetMaskBand();
    REQUIRE(b->RasterIO(GF_Read, column, row, 1, 1, &mask, 1, 1, GDT_Byte, 0, 0, nullptr) == CE_None);
    return mask != 0;
  }

 private:
  GDALDatasetUniquePtr dataset_;
  std::array<double, 6> from_pixel_{}, to_pixel_{};
  std::unique_ptr<OGRCoordinateTransformation> to_own_;
};

/// 150 places: our number at the centre of a pixel of ours against the file's pixels around that very place.
void check_control_points(const Raster& raster, const FileByGdal& file, bool exact, double slack) {
  const RasterInfo& info = raster.info();
  std::mt19937 random(7);
  int compared = 0, at_edges = 0;
  std::vector<std::array<uint32_t, 2>> places(150);  // row, column
  for (auto& place : places)
    place = {static_cast<uint32_t>(random() % info.height), static_cast<uint32_t>(random() % info.width)};
  std::sort(places.begin(), places.end());  // JPEG is decoded from the top
  for (const auto& [row, column] : places) {
    double lon = lon_of(info, column);
    const double lat = lat_of(info, row);
    if (lon > 180.0) lon -= 360.0;
    const auto [x, y] = file.pixel(lon, lat);
    const auto c = static_cast<int>(std::floor(x)), r = static_cast<int>(std::floor(y));
    const std::vector<float> ours = values_at(raster, lon_of(info, column), lat);
    CAPTURE(lon);
    CAPTURE(lat);
    if (exact) {
      REQUIRE(file.inside(c, r));
      REQUIRE(ours.empty() == !file.valid(c, r));
      for (size_t b = 0; !ours.empty() && b < std::min<size_t>(3, info.bands); ++b)
        CHECK(static_cast<double>(ours[b]) == file.value(static_cast<int>(b) + 1, c, r));
      compared += ours.empty() ? 0 : 1;
      continue;
    }
    // Warped: bilinear among the four pixels whose centres surround the place, give or take 0.05 px.
    bool whole = true;
    std::array<double, 3> low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
    // Where our pixels are larger than the file's, GDAL's kernel is wider.
    const auto [east, south] = file.pixel(lon + (info.bounds.east_deg - info.bounds.west_deg) / info.width,
                                          lat - (info.bounds.north_deg - info.bounds.south_deg) / info.height);
    const double reach_x = std::max(1.0, std::abs(east - x)) - 0.45,
                 reach_y = std::max(1.0, std::abs(south - y)) - 0.45;
    for (int px = static_cast<int>(std::floor(x - reach_x)); px <= static_cast<int>(std::floor(x + reach_x)); ++px)
      for (int py = static_cast<int>(std::floor(y - reach_y)); py <= static_cast<int>(std::floor(y + reach_y)); ++py) {
        if (!file.inside(px, py) || !file.valid(px, py)) {
          whole = false;
          continue;
        }
        for (size_t b = 0; b < std::min<size_t>(3, info.bands); ++b) {
          low[b] = std::min(low[b], file.value(static_cast<int>(b) + 1, px, py));
          high[b] = std::max(high[b], file.value(static_cast<int>(b) + 1, px, py));
        }
      }
    if (!whole) {
      ++at_edges;
      continue;
    }
    REQUIRE_FALSE(ours.empty());
    ++compared;
    for (size_t b = 0; b < std::min<size_t>(3, info.bands); ++b) {
      CHECK(static_cast<double>(ours[b]) >= low[b] - slack);
      CHECK(static_cast<double>(ours[b]) <= high[b] + slack);
    }
  }
  CHECK(compared >= 60);
  CAPTURE(at_edges);
}

}  // namespace

TEST_CASE("control points: every elevation file agrees with GDAL's own reading") {
  const auto data = shared_data();
  if (data.empty()) return;
  int files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(data / "dem")) {
    if (entry.path().extension() == ".xml") continue;
    CAPTURE(entry.path().string());
    check_control_points(*make_gdal_opener()->open_elevation(entry.path().string()), FileByGdal(entry.path().string()),
                         true, 0.0);
    ++files;
  }
  CHECK(files >= 3);
}

TEST_CASE("control points: every picture agrees with GDAL's own reading") {
  const auto data = shared_data();
  if (data.empty()) return;
  int files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(data / "imagery")) {
    if (entry.path().extension() == ".xml" || entry.is_directory()) continue;
    const std::string path = entry.path().string();
    CAPTURE(path);
    const bool warped = entry.path().extension() == ".mbtiles" || path.find("utm") != std::string::npos;
    check_control_points(*make_gdal_opener()->open_imagery(path), FileByGdal(path), !warped, 1.0);
    ++files;
  }
  CHECK(files >= 6);
}

TEST_CASE("control points: the folder of tiles is the MBTiles file that was made of them") {
  const auto data = shared_data();
  if (data.empty()) return;
  const std::string mbtiles = (data / "imagery/bluemarble_z0-3_DERIVED.mbtiles").string();
  const auto folder = make_gdal_opener()->open_imagery((data / "imagery/bluemarble_xyz").string());
  check_control_points(*folder, FileByGdal(mbtiles), false, 1.0);
  const auto packed = make_gdal_opener()->open_imagery(mbtiles);
  CHECK(folder->info().width == packed->info().width);
  // Each reduction comes from a zoom of the pyramid, the same in both.
  for (uint32_t k = 0; k < 3; ++k) {
    CAPTURE(k);
    CHECK(folder->pyramid_level(k) == k);
    CHECK(packed->pyramid_level(k) == k);
    const Result<RasterBlock> a = folder->read_block(k, 0, 0), b = packed->read_block(k, 0, 0);
    REQUIRE(a->values.size() == b->values.size());
    float most = 0.0f;
    for (size_t i = 0; i < a->values.size(); ++i)
      if (a->valid[i / 4] && b->valid[i / 4]) most = std::max(most, std::abs(a->values[i] - b->values[i]));
    CHECK(most <= 3.0f);
  }
}

TEST_CASE("control points: the folders of the real data are sources too") {
  const auto data = shared_data();
  if (data.empty()) return;
  const auto dem = make_gdal_opener()->open_elevation_parts((data / "dem").string(), {});
  REQUIRE(dem.size() == 3);  // by name; a degree each, far from each other
  CHECK(values_at(*dem[0], 1.5, 42.5) == std::vector<float>{1095});
  CHECK(values_at(*dem[1], 8.5, 46.25) == std::vector<float>{2157});
  CHECK(values_at(*dem[2], 138.7275, 35.3625) == std::vector<float>{3703});
  for (const auto& part : dem) CHECK(part->info().width == 1201);
}
