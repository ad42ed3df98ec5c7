#pragma once
#include <mutex>
#include <vector>

#include "io/raster.h"
#include "rasters/band_plan.h"
#include "rasters/georeference.h"

namespace nepho {

/// A GDAL dataset on the EPSG:4326 grid, delivered in blocks. One reader at a time: a dataset has one state.
class GdalRaster final : public Raster {
 public:
  /// `datasets`: the last one is read; the others are what it is made from.
  GdalRaster(RasterInfo info, std::vector<GDALDatasetUniquePtr> datasets, PixelGrid grid, BandPlan plan);
  ~GdalRaster() override;
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override;
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override;
  uint32_t pyramid_level(uint32_t reduction) const override { return level_for(reduction).level; }

 private:
  /// A level of the file's own pyramid: `bands` at half the size `level` times; level 0 is the dataset itself.
  struct Level {
    uint32_t level = 0;
    std::vector<GDALRasterBand*> colors;
    GDALRasterBand* alpha = nullptr;
    uint32_t width = 0, height = 0;  // px delivered
    int x_off = 0, y_off = 0;        // of the delivered pixels in the bands
  };
  struct Scratch {
    std::vector<float> raw;  ///< colours, then alpha, one band after the other
    std::vector<uint8_t> mask;
  };
  void find_levels();
  const Level& level_for(uint32_t reduction) const;
  /// Raw numbers of delivered rows y0 .. y0 + rows, in the dataset's own order, and which of them are data.
  bool read_raw(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) const;
  bool read_mask(const Level& level, int x, int y, int width, int rows) const;
  /// One delivered row out of what read_raw() left.
  void deliver_row(uint32_t row, uint32_t width, uint32_t rows, std::vector<float>& values,
                   std::vector<uint8_t>& valid) const;

  RasterInfo info_;
  std::vector<GDALDatasetUniquePtr> datasets_;  // destroyed last to first
  PixelGrid grid_;
  BandPlan plan_;
  std::vector<Level> levels_;  // fine to coarse
  mutable std::mutex mutex_;
  mutable Scratch scratch_;  // guarded by mutex_
};

}  // namespace nepho
