#include "rasters/gdal_opener.h"

#include <mutex>
#include <set>
#include <utility>

#include "base/log.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_raster.h"
#include "rasters/gdal_source.h"

namespace nepho {

namespace {

class GdalOpener final : public RasterOpener {
 public:
  std::shared_ptr<Raster> open_elevation(const std::string& path, const RasterReading& how) const override {
    return open_one(path, RasterUse::elevation, how);
  }
  std::shared_ptr<Raster> open_imagery(const std::string& path, const RasterReading& how) const override {
    return open_one(path, RasterUse::imagery, how);
  }
  std::vector<std::shared_ptr<Raster>> open_elevation_parts(const std::string& path,
                                                            const RasterReading& how) const override {
    return open(path, RasterUse::elevation, how);
  }
  std::vector<std::shared_ptr<Raster>> open_imagery_parts(const std::string& path,
                                                          const RasterReading& how) const override {
    return open(path, RasterUse::imagery, how);
  }
  std::shared_ptr<Raster> open_weather(const std::string& path) const override {
    return open_one(path, RasterUse::weather, {});
  }
  std::shared_ptr<Raster> open_tile(const std::string& path) const override {
    return open_one(path, RasterUse::weather_tile, {});
  }

 private:
  std::shared_ptr<Raster> open_one(const std::string& path, RasterUse use, const RasterReading& how) const {
    std::vector<std::shared_ptr<Raster>> parts = open(path, use, how);
    if (parts.size() > 1)
      throw fail(ErrorKind::input,
                 "{}: its rasters make {} grids (other CRSs or resolutions, or far apart), and here one is needed; "
                 "gdalwarp -t_srs EPSG:4326 makes one of them",
                 path, parts.size());
    return parts.front();
  }

  std::vector<std::shared_ptr<Raster>> open(const std::string& path, RasterUse use, const RasterReading& how) const {
    std::vector<std::shared_ptr<Raster>> rasters;
    for (OpenedSource& opened : open_sources(path, use, how))
      rasters.push_back(raster_of(std::move(opened), path, how));
    return rasters;
  }

  std::shared_ptr<Raster> raster_of(OpenedSource opened, const std::string& path, const RasterReading& how) const {
    const auto source = std::make_shared<const GdalSource>(std::move(opened.source));
    const RasterLayout& layout = source->layout;
    if (layout.grid.assumed_global) warn_once(path);
    RasterInfo info;
    info.path = path;
    info.vertical = source->vertical;
    info.opacity = source->use == RasterUse::elevation ? how.opacity : 1.0;
    info.fingerprint = source->fingerprint;
    info.width = layout.width;
    info.height = layout.height;
    info.bands = layout.plan.elevation ? 1 : layout.plan.weather ? static_cast<uint32_t>(layout.plan.weather) : 4;
    info.bounds = layout.grid.bounds;
    info.wraps = layout.grid.wraps;
    if (source->warp) info.oversampling = 1u << source->warp->finer_levels;
    return std::make_shared<GdalRaster>(
        std::move(info), layout, std::move(opened.chain), [source] { return source->open(); }, source->most_openings);
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
