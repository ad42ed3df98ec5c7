#include "rasters/gdal_source.h"

#include <cpl_vsi.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "base/error.h"
#include "rasters/raster_folder.h"
#include "rasters/tile_dataset.h"

namespace nepho {

namespace {

constexpr int kLargestWeatherTile = 4096;

bool is_folder(const std::string& path) {
  VSIStatBufL stat;
  return VSIStatL(path.c_str(), &stat) == 0 && VSI_ISDIR(stat.st_mode);
}

/// A format that opens folders (Zarr, SAFE, ESRI grids).
bool gdal_opens(const std::string& path) {
  const GdalMessages quiet;
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  return dataset != nullptr;
}

/// Size and time of a file; empty where there is none.
std::string stamp_of(const std::string& file) {
  VSIStatBufL stat;
  if (VSIStatL(file.c_str(), &stat) != 0) return "";
  return fmt::format("{}@{}", static_cast<int64_t>(stat.st_size), static_cast<int64_t>(stat.st_mtime));
}

/// Settles `dataset` or `tiles` of a source.
void find_out(GdalSource& source, const RasterReading& how, const GdalMessages& messages) {
  const std::string& path = source.path;
  const bool ground = source.use == RasterUse::elevation || source.use == RasterUse::imagery;
  source.dataset = path;
  if (ground && is_tile_template(path)) {
    source.tiles = find_tiles(path, path, how, source.use == RasterUse::elevation, messages);
  } else if (ground && is_folder(path)) {
    std::string folder = path;
    while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
    if (const std::optional<std::string> tiles = tile_template_of_folder(folder)) {
      source.tiles = find_tiles(path, *tiles, how, source.use == RasterUse::elevation, messages);
    } else if (!gdal_opens(path)) {
      const RasterMosaic mosaic = mosaic_of_folder(folder, source.use == RasterUse::elevation, messages);
      source.dataset = mosaic.name;
      for (const std::string& file : mosaic.files) source.fingerprint += file + stamp_of(file) + "\n";
    }
  }
  // Of tiles nothing cheap tells whether one has changed.
  source.fingerprint = fmt::format(
      "{} {} scale {} code {} stretch {} {} opacity {} zoom {} {}",
      source.fingerprint.empty() ? stamp_of(path) : std::to_string(std::hash<std::string>()(source.fingerprint)),
      static_cast<int>(source.use), how.vertical_scale, how.encoding, how.stretch,
      how.black_white ? fmt::format("{}:{}", (*how.black_white)[0], (*how.black_white)[1]) : "auto", how.opacity,
      how.min_zoom, how.max_zoom);
}

GDALDatasetUniquePtr open_root(const GdalSource& source, bool again, const GdalMessages& messages) {
  if (source.tiles) return make_tile_dataset(*source.tiles);
  if (!again) return open_dataset(source.dataset, messages, source.path);
  GDALDatasetUniquePtr dataset(
      GDALDataset::Open(source.dataset.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR));
  if (!dataset) throw fail(ErrorKind::input, "{}: cannot be opened again{}", source.path, messages.in_brackets());
  return dataset;
}

void push(DatasetChain& chain, GDALDatasetUniquePtr dataset) { chain.datasets.push_back(std::move(dataset)); }

void push_warped(DatasetChain& chain, const GdalSource& source, const GdalMessages& messages) {
  GDALDataset& flat = *chain.datasets.back();
  for (const WarpPlan::Level& level : source.warp->levels) {
    // Coarse levels that no block starts from are not made.
    push(chain, warp(flat, *source.warp, level, source.path, messages));
    chain.levels.push_back({level.level, chain.datasets.back().get()});
  }
}

BandPlan plan_bands(GDALDataset& dataset, const GdalSource& source, const RasterReading& how,
                    const GdalMessages& messages) {
  if (source.use == RasterUse::elevation) return plan_elevation(dataset, source.path);
  if (source.use == RasterUse::imagery) return plan_imagery(dataset, source.path, how, messages);
  return plan_weather(dataset, source.path, messages);
}

/// Whether the coarser levels of a dataset were made to be looked at.
bool is_tiled_for_viewing(const GdalSource& source, GDALDataset& root) {
  if (source.tiles) return true;
  const std::string driver = root.GetDriver() ? root.GetDriverName() : "";
  return driver == "MBTiles" || driver == "WMS" || driver == "WMTS" || driver == "GPKG";
}

/// Formats that are decoded from the top: a second opening would decode it all again.
bool is_sequential(GDALDataset& root) {
  const std::string driver = root.GetDriver() ? root.GetDriverName() : "";
  return driver == "JPEG" || driver == "PNG" || driver == "GIF" || driver == "BMP" || driver == "WEBP";
}

void settle_layout(GdalSource& source, const PixelGrid& grid, const RasterReading& how, GDALDataset& root) {
  RasterLayout& layout = source.layout;
  layout.grid = grid;
  layout.width = static_cast<uint32_t>(grid.width);
  layout.height = static_cast<uint32_t>(grid.height);
  layout.plan.exaggeration = how.vertical_scale;
  layout.plan.opacity = how.opacity;
  if (is_tiled_for_viewing(source, root)) layout.averaged_reductions = 0;
  constexpr size_t kMostOpenings = 8;
  source.most_openings =
      is_sequential(root) ? 1 : std::clamp<size_t>(std::thread::hardware_concurrency(), 1, kMostOpenings);
}

}  // namespace

DatasetChain GdalSource::open() const {
  const GdalMessages messages;
  DatasetChain chain;
  push(chain, open_root(*this, true, messages));
  if (code != HeightCode::none) push(chain, decode_heights(*chain.datasets.back(), code));
  if (expand_palette)
    for (GDALDatasetUniquePtr& step : nepho::expand_palette(*chain.datasets.back(), path)) push(chain, std::move(step));
  if (warp)
    push_warped(chain, *this, messages);
  else
    chain.levels.push_back({0, chain.datasets.back().get()});
  return chain;
}

OpenedSource open_source(const std::string& path, RasterUse use, const RasterReading& how) {
  init_gdal();
  set_network_timeout(how.timeout_s);
  const GdalMessages messages;
  OpenedSource opened;
  GdalSource& source = opened.source;
  DatasetChain& chain = opened.chain;
  source.path = path;
  source.use = use;
  refuse_pipes(path);
  find_out(source, how, messages);
  push(chain, open_root(source, false, messages));
  GDALDataset& root = *chain.datasets.front();
  if (use == RasterUse::elevation) {
    source.vertical = how.vertical ? *how.vertical : vertical_datum(root, path);
    source.code = height_code(root, how.encoding, path);
    if (source.code != HeightCode::none) push(chain, decode_heights(root, source.code));
  }
  if (use == RasterUse::weather_tile) {
    PixelGrid grid;
    grid.wraps = true;
    grid.width = root.GetRasterXSize();
    grid.height = root.GetRasterYSize();
    if (std::max(grid.width, grid.height) > kLargestWeatherTile)
      throw fail(ErrorKind::input, "{}: is {} x {} pixels; a weather tile has at most {} a side", path, grid.width,
                 grid.height, kLargestWeatherTile);
    source.layout.plan = plan_bands(root, source, how, messages);
    chain.levels.push_back({0, &root});
    settle_layout(source, grid, how, root);
    return opened;
  }
  // The grid first: it throws for what has no place, before any pixel is looked at.
  std::optional<PixelGrid> grid = native_grid(*chain.datasets.back(), path, messages);
  BandPlan& plan = source.layout.plan;
  plan = plan_bands(*chain.datasets.back(), source, how, messages);
  if (grid) {
    chain.levels.push_back({0, chain.datasets.back().get()});
  } else {
    if (!plan.palette.empty()) {  // colours can be blended, indices cannot
      source.expand_palette = true;
      for (GDALDatasetUniquePtr& step : expand_palette(*chain.datasets.back(), path)) push(chain, std::move(step));
      plan = plan_bands(*chain.datasets.back(), source, how, messages);
    }
    source.warp = plan_warp(*chain.datasets.back(), path, use == RasterUse::elevation, plan.alpha_max, messages,
                            use == RasterUse::weather);
    push_warped(chain, source, messages);
    grid = source.warp->grid;
    // As the warper was asked for.
    plan.alpha = use == RasterUse::elevation ? 0 : chain.levels.front().dataset->GetRasterCount();
  }
  settle_layout(source, *grid, how, root);
  return opened;
}

}  // namespace nepho
