#pragma once
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "io/raster.h"
#include "rasters/dataset_handle.h"

namespace nepho {

/// A GDAL dataset on the EPSG:4326 grid, delivered in blocks. A dataset has one state and serves one reader: others get
/// openings of their own, up to a number, and wait beyond it.
class GdalRaster final : public Raster {
 public:
  using Open = std::function<DatasetChain()>;
  /// `first`: what is open already; `open` opens the same again and may throw Error.
  GdalRaster(RasterInfo info, RasterLayout layout, DatasetChain first, Open open, size_t most_openings);
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override;
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override;
  uint32_t pyramid_level(uint32_t reduction) const override;

 private:
  /// A handle for as long as it lives.
  class Lease;
  std::unique_ptr<DatasetHandle> take() const;
  void give_back(std::unique_ptr<DatasetHandle> handle) const;

  RasterInfo info_;
  RasterLayout layout_;  // before the handles, which refer to it
  Open open_;
  std::vector<uint32_t> level_of_reduction_;
  mutable size_t most_openings_;
  mutable std::mutex mutex_;
  mutable std::condition_variable returned_;
  mutable size_t openings_ = 1;
  mutable std::vector<std::unique_ptr<DatasetHandle>> idle_;
};

}  // namespace nepho
