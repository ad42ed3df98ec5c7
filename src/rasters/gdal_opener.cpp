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
  std::shared_ptr<Raster> open_elevation(const std::string& path, const RasterReading&) const override {
    return open(path, As::elevation);
  }
  std::shared_ptr<Raster> open_imagery(const std::string& path, const RasterReading&) const override {
    return open(path, As::imagery);
  }
  std::shared_ptr<Raster> open_weather(const std::string& path) const override { return open(path, As::weather); }

  std::shared_ptr<Raster> open_tile(const std::string& path) const override {
    init_gdal();
    const GdalMessages messages;
    std::vector<GDALDatasetUniquePtr> datasets;
    datasets.push_back(open_dataset(path, messages));
    PixelGrid grid;
    grid.wraps = true;
    grid.width = datasets[0]->GetRasterXSize();
    grid.height = datasets[0]->GetRasterYSize();
    if (std::max(grid.width, grid.height) > kLargestTile)
      throw fail(ErrorKind::input, "{}: is {} x {} pixels; a weather tile has at most {} a side", path, grid.width,
                 grid.height, kLargestTile);
    BandPlan plan = plan_weather(*datasets[0], path, messages);
    return make_raster(path, VerticalDatum::egm96, std::move(datasets), grid, std::move(plan));
  }

 private:
  enum class As { elevation, imagery, weather };
  static constexpr int kLargestTile = 4096;

  static BandPlan plan_for(As as, GDALDataset& dataset, const std::string& path, const GdalMessages& messages) {
    switch (as) {
      case As::elevation:
        return plan_elevation(dataset, path);
      case As::imagery:
        return plan_imagery(dataset, path, messages);
      case As::weather:
        break;
    }
    return plan_weather(dataset, path, messages);
  }

  static std::shared_ptr<Raster> make_raster(const std::string& path, VerticalDatum vertical,
                                             std::vector<GDALDatasetUniquePtr> datasets, const PixelGrid& grid,
                                             BandPlan plan) {
    RasterInfo info;
    info.path = path;
    info.vertical = vertical;
    info.width = static_cast<uint32_t>(grid.width);
    info.height = static_cast<uint32_t>(grid.height);
    info.bands = plan.elevation ? 1 : plan.weather ? static_cast<uint32_t>(plan.weather) : 4;
    info.bounds = grid.bounds;
    info.wraps = grid.wraps;
    return std::make_shared<GdalRaster>(std::move(info), std::move(datasets), grid, std::move(plan));
  }

  std::shared_ptr<Raster> open(const std::string& path, As as) const {
    init_gdal();
    const GdalMessages messages;
    std::vector<GDALDatasetUniquePtr> datasets;
    datasets.push_back(open_dataset(path, messages));
    const VerticalDatum vertical = as == As::elevation ? vertical_datum(*datasets.back(), path) : VerticalDatum::egm96;
    // The grid first: it throws for what has no place, before any pixel is looked at.
    std::optional<PixelGrid> grid = native_grid(*datasets.back(), path, messages);
    BandPlan plan = plan_for(as, *datasets.back(), path, messages);
    if (!grid) {
      if (!plan.palette.empty()) {  // colours can be blended, indices cannot
        for (GDALDatasetUniquePtr& step : expand_palette(*datasets.back(), path)) datasets.push_back(std::move(step));
        plan = plan_for(as, *datasets.back(), path, messages);
      }
      WarpedDataset warped =
          warp_to_lon_lat(*datasets.back(), path, as == As::elevation, plan.alpha_max, messages, as == As::weather);
      datasets.push_back(std::move(warped.dataset));
      grid = warped.grid;
      plan.alpha = as == As::elevation ? 0 : datasets.back()->GetRasterCount();  // as the warper was asked for
    }
    if (grid->assumed_global) warn_once(path);
    return make_raster(path, vertical, std::move(datasets), *grid, std::move(plan));
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
