#pragma once
#include <cstdint>
#include <vector>

#include "rasters/band_plan.h"
#include "rasters/georeference.h"

namespace nepho {

/// A dataset that was opened, with what it is made from.
struct DatasetChain {
  struct Level {
    uint32_t level = 0;  ///< half the size so many times
    GDALDataset* dataset = nullptr;
  };
  std::vector<GDALDatasetUniquePtr> datasets;  ///< each may need those before it: closed last to first
  std::vector<Level> levels;                   ///< those to read, level 0 first; owned by `datasets`

  DatasetChain() = default;
  DatasetChain(DatasetChain&&) = default;
  DatasetChain& operator=(DatasetChain&&) = delete;
  ~DatasetChain() {
    while (!datasets.empty()) datasets.pop_back();
  }
};

/// What does not change from one opening of a raster to the next.
struct RasterLayout {
  uint32_t width = 0, height = 0;  ///< px delivered
  PixelGrid grid;
  BandPlan plan;
  /// A pyramid of a file may have been made by picking pixels rather than averaging: each delivered pixel averages at
  /// least 2^this by 2^this of its pixels, which also bounds what a block costs. 0 for tiles, whose zooms are meant to
  /// be looked at.
  uint32_t averaged_reductions = 3;
  /// Level 0 is this many times halved finer than the source: the levels up to here are all warped from its own pixels.
  uint32_t finer_levels = 0;
};

/// One opening of a raster: reads raw numbers, for one thread at a time.
class DatasetHandle {
 public:
  /// `layout` must outlive it.
  DatasetHandle(DatasetChain chain, const RasterLayout& layout);

  /// A level of the pyramid: the file's own, or warped from it.
  struct Level {
    uint32_t level = 0;
    std::vector<GDALRasterBand*> colors;
    GDALRasterBand* alpha = nullptr;
    uint32_t width = 0, height = 0;  ///< px delivered
    int x_off = 0, y_off = 0;        ///< of the delivered pixels in the bands
  };
  /// The coarsest level for a reduction.
  const Level& level_for(uint32_t reduction) const;
  /// Raw numbers of delivered rows y0 .. y0 + rows, in the dataset's own order, and which of them are data.
  bool read_raw(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows);
  /// Whether nothing was ever put there, so that it need not be read: between the parts of a mosaic, in sparse files.
  bool is_empty(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) const;
  /// One delivered row out of what read_raw() left.
  void deliver(uint32_t row, uint32_t width, uint32_t rows, uint32_t bands, std::vector<float>& values,
               std::vector<uint8_t>& valid) const;

 private:
  struct Window {
    int x, y;
  };
  /// Where delivered pixels begin in the bands.
  Window window_of(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) const;
  void find_levels();
  bool read_mask(const Level& level, int x, int y, int width, int rows);

  DatasetChain chain_;
  const RasterLayout& layout_;
  std::vector<Level> levels_;  // fine to coarse
  std::vector<float> raw_;     // colours, then alpha, one band after the other
  std::vector<uint8_t> mask_;
};

}  // namespace nepho
