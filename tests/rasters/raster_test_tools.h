#pragma once
#include <cpl_error.h>
#include <doctest/doctest.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/file_test_tools.h"
#include "io/raster.h"

namespace nepho::test {

/// What a synthetic raster is made of; `value` gets band (from 0), column and row.
struct RasterRecipe {
  int width = 0, height = 0, bands = 1;
  GDALDataType type = GDT_Float32;
  std::array<double, 6> geotransform{};  ///< all zero: none
  std::string crs{};                     ///< anything that OGR understands; empty: none
  std::function<double(int, int, int)> value{};
  std::function<void(GDALDataset&)> finish{};  ///< before the pixels are written: nodata, palette, colours
  std::vector<std::string> options{};          ///< creation options
  std::string driver = "GTiff";
};

inline OGRSpatialReference srs_of(const std::string& crs) {
  OGRSpatialReference srs;
  REQUIRE(srs.SetFromUserInput(crs.c_str()) == OGRERR_NONE);
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

inline void fill(GDALDataset& dataset, const RasterRecipe& r) {
  std::vector<double> row(static_cast<size_t>(r.width));
  for (int b = 0; b < r.bands; ++b)
    for (int y = 0; y < r.height; ++y) {
      for (int x = 0; x < r.width; ++x) row[static_cast<size_t>(x)] = r.value(b, x, y);
      const CPLErr written = dataset.GetRasterBand(b + 1)->RasterIO(GF_Write, 0, y, r.width, 1, row.data(), r.width, 1,
                                                                    GDT_Float64, 0, 0, nullptr);
      if (written != CE_None) FAIL("a synthetic raster cannot be written");
    }
}

/// Writes a raster file and returns its path.
inline std::string make_raster(const std::filesystem::path& path, const RasterRecipe& r) {
  GDALAllRegister();
  const bool copies = r.driver == "PNG" || r.driver == "JPEG";  // written from a finished picture only
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(copies ? "MEM" : r.driver.c_str());
  REQUIRE(driver != nullptr);
  CPLStringList options;
  for (const std::string& option : r.options) options.AddString(option.c_str());
  GDALDatasetUniquePtr dataset(
      driver->Create(path.c_str(), r.width, r.height, r.bands, r.type, copies ? nullptr : options.List()));
  REQUIRE(dataset != nullptr);
  if (r.geotransform != std::array<double, 6>{}) {
    std::array<double, 6> g = r.geotransform;
    REQUIRE(dataset->SetGeoTransform(g.data()) == CE_None);
  }
  if (!r.crs.empty()) {
    const OGRSpatialReference srs = srs_of(r.crs);
    REQUIRE(dataset->SetSpatialRef(&srs) == CE_None);
  }
  if (r.finish) r.finish(*dataset);
  fill(*dataset, r);
  if (copies) {
    GDALDriver* final_driver = GetGDALDriverManager()->GetDriverByName(r.driver.c_str());
    GDALDatasetUniquePtr written(
        final_driver->CreateCopy(path.c_str(), dataset.get(), FALSE, options.List(), nullptr, nullptr));
    REQUIRE(written != nullptr);
  }
  return path.string();
}

/// The whole raster at a reduction, put together from its blocks.
inline RasterBlock read_all(const Raster& raster, uint32_t reduction = 0) {
  const RasterInfo& info = raster.info();
  const uint32_t bands = info.bands, factor = 1u << reduction;
  RasterBlock all;
  all.width = (info.width + factor - 1) / factor;
  all.height = (info.height + factor - 1) / factor;
  all.values.resize(size_t{all.width} * all.height * bands);
  all.valid.resize(size_t{all.width} * all.height);
  for (uint32_t y0 = 0; y0 < all.height; y0 += Raster::kBlockSize)
    for (uint32_t x0 = 0; x0 < all.width; x0 += Raster::kBlockSize) {
      const Result<RasterBlock> block = raster.read_block(reduction, x0 / Raster::kBlockSize, y0 / Raster::kBlockSize);
      REQUIRE_MESSAGE(static_cast<bool>(block), block.reason());
      for (uint32_t y = 0; y < block->height; ++y)
        for (uint32_t x = 0; x < block->width; ++x) {
          const size_t from = size_t{y} * block->width + x, to = size_t{y0 + y} * all.width + x0 + x;
          all.valid[to] = block->valid[from];
          for (uint32_t b = 0; b < bands; ++b) all.values[to * bands + b] = block->values[from * bands + b];
        }
    }
  return all;
}

/// Column and row of the pixel that holds a place, by the rule in io/raster.h.
inline std::pair<uint32_t, uint32_t> pixel_at(const RasterInfo& info, double lon_deg, double lat_deg) {
  const LonLatBounds& b = info.bounds;
  const double along = std::fmod(lon_deg - b.west_deg + 720.0, 360.0) / (b.east_deg - b.west_deg);
  const double down = (b.north_deg - lat_deg) / (b.north_deg - b.south_deg);
  return {static_cast<uint32_t>(along * info.width), static_cast<uint32_t>(down * info.height)};
}

/// Values of the pixel that holds a place; empty where it is invalid.
inline std::vector<float> values_at(const Raster& raster, double lon_deg, double lat_deg) {
  const auto [column, row] = pixel_at(raster.info(), lon_deg, lat_deg);
  const auto block = raster.read_block(0, column / Raster::kBlockSize, row / Raster::kBlockSize);
  REQUIRE_MESSAGE(static_cast<bool>(block), block.reason());
  const size_t i = size_t{row % Raster::kBlockSize} * block->width + column % Raster::kBlockSize;
  if (!block->valid[i]) return {};
  const auto first = block->values.begin() + static_cast<std::ptrdiff_t>(i * raster.info().bands);
  return {first, first + raster.info().bands};
}

inline double lon_of(const RasterInfo& info, double column) {
  return info.bounds.west_deg + (column + 0.5) * (info.bounds.east_deg - info.bounds.west_deg) / info.width;
}
inline double lat_of(const RasterInfo& info, double row) {
  return info.bounds.north_deg - (row + 0.5) * (info.bounds.north_deg - info.bounds.south_deg) / info.height;
}

/// Standard error of this process while it lives.
class StderrCapture {
 public:
  StderrCapture() : file_(std::tmpfile()), saved_(dup(STDERR_FILENO)) {
    std::fflush(stderr);
    dup2(fileno(file_), STDERR_FILENO);
  }
  ~StderrCapture() {
    restore();
    std::fclose(file_);
  }
  StderrCapture(const StderrCapture&) = delete;
  StderrCapture& operator=(const StderrCapture&) = delete;
  std::string text() {
    restore();
    std::string all;
    std::rewind(file_);
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) all += static_cast<char>(c);
    return all;
  }

 private:
  void restore() {
    std::fflush(stderr);
    if (saved_ < 0) return;
    dup2(saved_, STDERR_FILENO);
    close(saved_);
    saved_ = -1;
  }
  std::FILE* file_;
  int saved_;
};

}  // namespace nepho::test
