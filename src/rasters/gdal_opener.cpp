#include "rasters/gdal_opener.h"

#include <mutex>
#include <set>
#include <utility>

#include "base/log.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_raster.h"

namespace nepho {

namespace {

class GdalOpener final : public RasterOpener {
 public:
  std::shared_ptr<Raster> open_elevation(const std::string& path) const override { return open(path, true); }
  std::shared_ptr<Raster> open_imagery(const std::string& path) const override { return open(path, false); }

 private:
  std::shared_ptr<Raster> open(const std::string& path, bool elevation) const {
    init_gdal();
    const GdalMessages messages;
    std::vector<GDALDatasetUniquePtr> datasets;
    datasets.push_back(open_dataset(path, messages));
    RasterInfo info;
    info.path = path;
    if (elevation) info.vertical = vertical_datum(*datasets.back(), path);
    // The grid first: it throws for what has no place, before any pixel is looked at.
    std::optional<PixelGrid> grid = native_grid(*datasets.back(), path, messages);
    BandPlan plan = elevation ? plan_elevation(*datasets.back(), path) : plan_imagery(*datasets.back(), path, messages);
    if (!grid) {
      if (!plan.palette.empty()) {  // colours can be blended, indices cannot
        for (GDALDatasetUniquePtr& step : expand_palette(*datasets.back(), path)) datasets.push_back(std::move(step));
        plan = plan_imagery(*datasets.back(), path, messages);
      }
      WarpedDataset warped = warp_to_lon_lat(*datasets.back(), path, elevation, plan.alpha_max, messages);
      datasets.push_back(std::move(warped.dataset));
      grid = warped.grid;
      plan.alpha = elevation ? 0 : datasets.back()->GetRasterCount();  // as the warper was asked for
    }
    if (grid->assumed_global) warn_once(path);
    info.width = static_cast<uint32_t>(grid->width);
    info.height = static_cast<uint32_t>(grid->height);
    info.bands = elevation ? 1 : 4;
    info.bounds = grid->bounds;
    info.wraps = grid->wraps;
    return std::make_shared<GdalRaster>(std::move(info), std::move(datasets), *grid, std::move(plan));
  }

  void warn_once(const std::string& path) const {
    const std::lock_guard lock(mutex_);
    if (is_default_earth_file(path) || !warned_.insert(path).second) return;
    log_warning("{}: no georeference; 2:1, so taken as the whole globe, longitude -180 to 180", path);
  }

  mutable std::mutex mutex_;
  mutable std::set<std::string> warned_;
};

}  // namespace

std::unique_ptr<RasterOpener> make_gdal_opener() { return std::make_unique<GdalOpener>(); }

}  // namespace nepho
