#include "rasters/height_colours.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <memory>
#include <vector>

namespace nepho {

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

float decoded(HeightCode code, uint8_t r, uint8_t g, uint8_t b) {
  if (code == HeightCode::terrarium) return static_cast<float>(256 * r + g) + static_cast<float>(b) / 256.0f - 32768.0f;
  return static_cast<float>(0.1 * (65536 * r + 256 * g + b) - 10000.0);
}

class HeightDataset;

class HeightBand final : public GDALRasterBand {
 public:
  explicit HeightBand(HeightDataset& dataset);
  CPLErr IReadBlock(int bx, int by, void* out) override;
  GDALColorInterp GetColorInterpretation() override { return GCI_GrayIndex; }
  double GetNoDataValue(int* has) override {
    if (has) *has = TRUE;
    return static_cast<double>(kNaN);
  }
  int GetOverviewCount() override;
  GDALRasterBand* GetOverview(int index) override;

 private:
  HeightDataset& heights_;
};

/// The first three bands of a picture (or of one of its overviews) as one of heights.
class HeightDataset final : public GDALDataset {
 public:
  HeightDataset(GDALDataset& place, std::array<GDALRasterBand*, 3> colours, HeightCode code, bool with_overviews)
      : place_(place), colours_(colours), code_(code) {
    nRasterXSize = colours[0]->GetXSize();
    nRasterYSize = colours[0]->GetYSize();
    eAccess = GA_ReadOnly;
    SetBand(1, new HeightBand(*this));
    for (int i = 0; with_overviews && i < colours[0]->GetOverviewCount(); ++i) {
      const std::array<GDALRasterBand*, 3> coarse = {colours[0]->GetOverview(i), colours[1]->GetOverview(i),
                                                     colours[2]->GetOverview(i)};
      if (coarse[0] && coarse[1] && coarse[2])
        overviews_.push_back(std::make_unique<HeightDataset>(place, coarse, code, false));
    }
  }
  const OGRSpatialReference* GetSpatialRef() const override { return place_.GetSpatialRef(); }
  CPLErr GetGeoTransform(double* g) override { return place_.GetGeoTransform(g); }
  GDALRasterBand& colour(size_t index) const { return *colours_[index]; }
  int overview_count() const { return static_cast<int>(overviews_.size()); }
  GDALRasterBand* overview(int index) const {
    return index >= 0 && index < overview_count() ? overviews_[static_cast<size_t>(index)]->GetRasterBand(1) : nullptr;
  }
  HeightCode code() const { return code_; }

 private:
  GDALDataset& place_;
  std::array<GDALRasterBand*, 3> colours_;
  HeightCode code_;
  std::vector<std::unique_ptr<HeightDataset>> overviews_;
};

HeightBand::HeightBand(HeightDataset& dataset) : heights_(dataset) {
  poDS = &dataset;
  nBand = 1;
  eDataType = GDT_Float32;
  nRasterXSize = dataset.GetRasterXSize();
  nRasterYSize = dataset.GetRasterYSize();
  dataset.colour(0).GetBlockSize(&nBlockXSize, &nBlockYSize);
}

int HeightBand::GetOverviewCount() { return heights_.overview_count(); }
GDALRasterBand* HeightBand::GetOverview(int index) { return heights_.overview(index); }

CPLErr HeightBand::IReadBlock(int bx, int by, void* out) {
  const int x = bx * nBlockXSize, y = by * nBlockYSize;
  const int width = std::min(nBlockXSize, nRasterXSize - x), height = std::min(nBlockYSize, nRasterYSize - y);
  const auto pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  std::array<std::vector<uint8_t>, 4> bands;  // colours, then what counts
  for (size_t b = 0; b < 4; ++b) {
    bands[b].resize(pixels);
    GDALRasterBand& band = b < 3 ? heights_.colour(b) : *heights_.colour(0).GetMaskBand();
    if (band.RasterIO(GF_Read, x, y, width, height, bands[b].data(), width, height, GDT_Byte, 0, 0, nullptr) != CE_None)
      return CE_Failure;
  }
  auto* const values = static_cast<float*>(out);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const size_t p = static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i);
      values[static_cast<size_t>(j) * static_cast<size_t>(nBlockXSize) + static_cast<size_t>(i)] =
          bands[3][p] ? decoded(heights_.code(), bands[0][p], bands[1][p], bands[2][p]) : kNaN;
    }
  return CE_None;
}

/// Red numbers of the places with data in a small look at a picture, sorted.
std::vector<uint8_t> reds_of(GDALDataset& dataset) {
  GDALRasterBand* band = dataset.GetRasterBand(1);
  // The coarsest overview: others may be far away or large.
  GDALRasterBand* look = band->GetOverviewCount() > 0 ? band->GetOverview(band->GetOverviewCount() - 1) : band;
  if (!look) look = band;
  const int width = std::min(256, look->GetXSize()), height = std::min(256, look->GetYSize());
  std::vector<uint8_t> red(static_cast<size_t>(width) * static_cast<size_t>(height)), mask(red.size());
  if (look->RasterIO(GF_Read, 0, 0, look->GetXSize(), look->GetYSize(), red.data(), width, height, GDT_Byte, 0, 0,
                     nullptr) != CE_None ||
      look->GetMaskBand()->RasterIO(GF_Read, 0, 0, look->GetXSize(), look->GetYSize(), mask.data(), width, height,
                                    GDT_Byte, 0, 0, nullptr) != CE_None)
    return {};
  size_t kept = 0;
  for (size_t i = 0; i < red.size(); ++i)
    if (mask[i]) red[kept++] = red[i];
  red.resize(kept);
  std::sort(red.begin(), red.end());
  return red;
}

}  // namespace

HeightCode height_code(GDALDataset& dataset, const std::string& encoding, const std::string& path) {
  const int bands = dataset.GetRasterCount();
  if (encoding == "none" || bands < 3 || bands > 4) return HeightCode::none;
  for (int b = 1; b <= 3; ++b)
    if (dataset.GetRasterBand(b)->GetRasterDataType() != GDT_Byte) return HeightCode::none;
  if (encoding == "terrarium") return HeightCode::terrarium;
  if (encoding == "mapbox") return HeightCode::mapbox;
  std::string name = path;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.find("terrarium") != std::string::npos) return HeightCode::terrarium;
  for (const char* word : {"terrain-rgb", "terrain_rgb", "terrainrgb", "terrain-dem", "mapbox"})
    if (name.find(word) != std::string::npos) return HeightCode::mapbox;
  // From -11 km to 9 km red is 85..163 in one code, 0..2 in the other (1 or 2 from -3.4 km on).
  const std::vector<uint8_t> red = reds_of(dataset);
  if (red.size() < 16) return HeightCode::none;
  const auto at = [&](double share) { return red[static_cast<size_t>(share * static_cast<double>(red.size() - 1))]; };
  if (at(0.01) >= 85 && at(0.99) <= 163) return HeightCode::terrarium;
  if (at(0.99) <= 2 && at(0.5) >= 1) return HeightCode::mapbox;
  return HeightCode::none;
}

GDALDatasetUniquePtr decode_heights(GDALDataset& picture, HeightCode code) {
  const std::array<GDALRasterBand*, 3> colours = {picture.GetRasterBand(1), picture.GetRasterBand(2),
                                                  picture.GetRasterBand(3)};
  return GDALDatasetUniquePtr(new HeightDataset(picture, colours, code, true));
}

}  // namespace nepho
