#pragma once
#include <cstdint>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// A raster in memory: for tests, and for fields that the program makes itself. Immutable, so thread-safe.
class ArrayRaster final : public Raster {
 public:
  /// `values`: info.width * info.height * info.bands, row 0 northernmost, bands interleaved by pixel. `valid`: one flag
  /// per pixel, or empty where every finite pixel counts. Values that are not finite are invalid either way.
  ArrayRaster(RasterInfo info, std::vector<float> values, std::vector<uint8_t> valid = {});
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override;
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override;

 private:
  RasterInfo info_;
  std::vector<float> values_;
  std::vector<uint8_t> valid_;
};

}  // namespace nepho
