#include "rasters/tile_dataset.h"

#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "rasters/tile_file.h"

namespace nepho {

namespace {

constexpr double kMercatorHalf = 20037508.342789244;  // EPSG:3857 at longitude 180, m
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class TileDataset;

class TileBand final : public GDALRasterBand {
 public:
  TileBand(TileDataset& tiles, int number, GDALDataType type);
  CPLErr IReadBlock(int bx, int by, void* out) override;
  GDALColorInterp GetColorInterpretation() override;
  double GetNoDataValue(int* has) override;
  int GetOverviewCount() override;
  GDALRasterBand* GetOverview(int index) override;

 private:
  TileDataset& tiles_;
};

/// One zoom; the finest owns the others.
class TileDataset final : public GDALDataset {
 public:
  TileDataset(const TileSet& tiles, int zoom) : tiles_(tiles), zoom_(zoom) {
    const int level = tiles.max_zoom - zoom;
    nRasterXSize = static_cast<int>(((tiles.x1 - tiles.x0) >> level) * tiles.tile_px);
    nRasterYSize = static_cast<int>(((tiles.y1 - tiles.y0) >> level) * tiles.tile_px);
    eAccess = GA_ReadOnly;
    srs_.importFromEPSG(tiles.geodetic ? 4326 : 3857);
    srs_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const GDALDataType type = tiles.heights || !tiles.bytes ? GDT_Float32 : GDT_Byte;
    for (int b = 1; b <= (tiles.heights ? 1 : 4); ++b) SetBand(b, new TileBand(*this, b, type));
    // GDAL's block cache is asked for a tile's other bands at once.
    SetMetadataItem("INTERLEAVE", "PIXEL", "IMAGE_STRUCTURE");
  }
  const OGRSpatialReference* GetSpatialRef() const override { return &srs_; }
  CPLErr GetGeoTransform(double* g) override {
    const double half_width = tiles_.geodetic ? 180.0 : kMercatorHalf, top = tiles_.geodetic ? 90.0 : kMercatorHalf;
    const double tile = (tiles_.geodetic ? 180.0 : 2.0 * kMercatorHalf) / static_cast<double>(int64_t{1} << zoom_);
    const int level = tiles_.max_zoom - zoom_;
    g[0] = -half_width + tile * static_cast<double>(tiles_.x0 >> level);
    g[1] = tile / tiles_.tile_px;
    g[2] = g[4] = 0.0;
    g[3] = top - tile * static_cast<double>(tiles_.y0 >> level);
    g[5] = -tile / tiles_.tile_px;
    return CE_None;
  }
  void add_overview(std::unique_ptr<TileDataset> overview) { overviews_.push_back(std::move(overview)); }
  int overview_count() const { return static_cast<int>(overviews_.size()); }
  GDALRasterBand* overview(int index, int band) {
    return index >= 0 && index < overview_count() ? overviews_[static_cast<size_t>(index)]->GetRasterBand(band)
                                                  : nullptr;
  }
  const TileSet& tiles() const { return tiles_; }

  /// The pixels of a tile, band after band. Where it is missing, those of the nearest coarser zoom that has one there.
  template <typename T>
  bool load(int bx, int by, std::vector<T>& out) const {
    const int level = tiles_.max_zoom - zoom_;
    const int64_t x = (tiles_.x0 >> level) + bx, y = (tiles_.y0 >> level) + by;
    bool failed = false;
    GDALDatasetUniquePtr tile;
    Part part;
    for (int up = 0; !tile && !failed && zoom_ - up >= tiles_.coarsest_zoom && (tiles_.tile_px >> up) > 0; ++up) {
      tile = open_tile_file(tile_name(tiles_, zoom_ - up, x >> up, y >> up), failed);
      const double size = std::ldexp(1.0, -up);
      part = {static_cast<double>(x - ((x >> up) << up)) * size, static_cast<double>(y - ((y >> up) << up)) * size,
              size};
    }
    const auto pixels = static_cast<size_t>(tiles_.tile_px) * static_cast<size_t>(tiles_.tile_px);
    out.assign(pixels * (tiles_.heights ? 1 : 4), T{});
    if (failed) return false;
    if (tiles_.heights) std::fill(out.begin(), out.end(), static_cast<T>(kNaN));
    if (!tile || tile->GetRasterCount() == 0) return true;
    return tiles_.heights ? load_heights(*tile, part, out) : load_colours(*tile, part, out);
  }

 private:
  /// A square of a tile, in parts of the whole.
  struct Part {
    double x = 0.0, y = 0.0, size = 1.0;
  };
  /// Pixels are repeated where the part has fewer: numbers in code and numbers of colours cannot be mixed.
  template <typename T>
  bool read(GDALRasterBand& band, const Part& part, T* out) const {
    const int w = band.GetXSize(), h = band.GetYSize();
    const int x = std::min(static_cast<int>(part.x * w), w - 1), y = std::min(static_cast<int>(part.y * h), h - 1);
    const int part_w = std::max(1, static_cast<int>(part.size * w)),
              part_h = std::max(1, static_cast<int>(part.size * h));
    return band.RasterIO(GF_Read, x, y, part_w, part_h, out, tiles_.tile_px, tiles_.tile_px,
                         std::is_same_v<T, float> ? GDT_Float32 : GDT_Byte, 0, 0, nullptr) == CE_None;
  }
  /// 255 where there is data.
  bool read_mask(GDALRasterBand& band, const Part& part, std::vector<uint8_t>& mask) const {
    mask.assign(static_cast<size_t>(tiles_.tile_px) * static_cast<size_t>(tiles_.tile_px), 255);
    if (band.GetMaskFlags() == GMF_ALL_VALID) return true;
    return read(*band.GetMaskBand(), part, mask.data());
  }
  template <typename T>
  bool load_heights(GDALDataset& tile, const Part& part, std::vector<T>& out) const {
    GDALRasterBand& band = *tile.GetRasterBand(1);
    std::vector<uint8_t> mask;
    if (!read(band, part, out.data()) || !read_mask(band, part, mask)) return false;
    const double scale = band.GetScale(), offset = band.GetOffset();
    for (size_t i = 0; i < out.size(); ++i)
      out[i] = static_cast<T>(mask[i] ? static_cast<float>(static_cast<double>(out[i]) * scale + offset) : kNaN);
    return true;
  }
  template <typename T>
  bool load_colours(GDALDataset& tile, const Part& part, std::vector<T>& out) const {
    const size_t pixels = out.size() / 4;
    const int bands = tile.GetRasterCount();
    GDALRasterBand& first = *tile.GetRasterBand(1);
    std::vector<uint8_t> mask;
    if (const GDALColorTable* colours = first.GetColorTable(); colours && bands == 1) {
      if (!read_mask(first, part, mask)) return false;
      std::vector<uint8_t> index(pixels);
      if (!read(first, part, index.data())) return false;
      for (size_t i = 0; i < pixels; ++i) {
        GDALColorEntry entry{};
        colours->GetColorEntryAsRGB(index[i], &entry);
        out[i] = static_cast<T>(entry.c1);
        out[pixels + i] = static_cast<T>(entry.c2);
        out[2 * pixels + i] = static_cast<T>(entry.c3);
        out[3 * pixels + i] = static_cast<T>(mask[i] ? entry.c4 : 0);
      }
      return true;
    }
    for (size_t c = 0; c < 3; ++c)
      if (!read(*tile.GetRasterBand(bands >= 3 ? static_cast<int>(c) + 1 : 1), part, out.data() + c * pixels))
        return false;
    // Opacity 0..255 whatever the type: the mask band of a picture with alpha is its alpha, scaled to 8 bits.
    if (!read_mask(first, part, mask)) return false;
    for (size_t i = 0; i < pixels; ++i) out[3 * pixels + i] = static_cast<T>(mask[i]);
    return true;
  }

  TileSet tiles_;
  int zoom_;
  OGRSpatialReference srs_;
  std::vector<std::unique_ptr<TileDataset>> overviews_;
};

TileBand::TileBand(TileDataset& tiles, int number, GDALDataType type) : tiles_(tiles) {
  poDS = &tiles;
  nBand = number;
  eDataType = type;
  nRasterXSize = tiles.GetRasterXSize();
  nRasterYSize = tiles.GetRasterYSize();
  nBlockXSize = nBlockYSize = tiles.tiles().tile_px;
}

GDALColorInterp TileBand::GetColorInterpretation() {
  if (tiles_.tiles().heights) return GCI_GrayIndex;
  const GDALColorInterp meanings[] = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
  return meanings[nBand - 1];
}

double TileBand::GetNoDataValue(int* has) {
  if (has) *has = tiles_.tiles().heights ? TRUE : FALSE;
  return tiles_.tiles().heights ? static_cast<double>(kNaN) : 0.0;
}

int TileBand::GetOverviewCount() { return tiles_.overview_count(); }
GDALRasterBand* TileBand::GetOverview(int index) { return tiles_.overview(index, nBand); }

CPLErr TileBand::IReadBlock(int bx, int by, void* out) {
  const size_t pixels = static_cast<size_t>(nBlockXSize) * static_cast<size_t>(nBlockYSize);
  const auto read = [&](auto type) {
    using T = decltype(type);
    std::vector<T> values;
    if (!tiles_.load(bx, by, values)) return CE_Failure;
    std::memcpy(out, values.data() + static_cast<size_t>(nBand - 1) * pixels, pixels * sizeof(T));
    // The tile is decoded once: its other bands go to GDAL's block cache.
    for (int b = 1; b <= tiles_.GetRasterCount(); ++b) {
      if (b == nBand) continue;
      GDALRasterBlock* const block = tiles_.GetRasterBand(b)->GetLockedBlockRef(bx, by, TRUE);
      if (!block) continue;
      std::memcpy(block->GetDataRef(), values.data() + static_cast<size_t>(b - 1) * pixels, pixels * sizeof(T));
      block->DropLock();
    }
    return CE_None;
  };
  return eDataType == GDT_Byte ? read(uint8_t{}) : read(float{});
}

}  // namespace

GDALDatasetUniquePtr make_tile_dataset(const TileSet& wanted) {
  TileSet tiles = wanted;
  // Overviews until one tile is left; the range is widened so that each halves exactly.
  int levels = 0;
  const auto span = [&](int64_t a, int64_t b) { return ((b - 1) >> levels) - (a >> levels) + 1; };
  while (levels < tiles.max_zoom - tiles.min_zoom && (span(tiles.x0, tiles.x1) > 1 || span(tiles.y0, tiles.y1) > 1))
    ++levels;
  tiles.x0 = (tiles.x0 >> levels) << levels;
  tiles.y0 = (tiles.y0 >> levels) << levels;
  tiles.x1 = (((tiles.x1 - 1) >> levels) + 1) << levels;
  tiles.y1 = (((tiles.y1 - 1) >> levels) + 1) << levels;
  auto full = std::make_unique<TileDataset>(tiles, tiles.max_zoom);
  for (int level = 1; level <= levels; ++level)
    full->add_overview(std::make_unique<TileDataset>(tiles, tiles.max_zoom - level));
  return GDALDatasetUniquePtr(full.release());
}

}  // namespace nepho
