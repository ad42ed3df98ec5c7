#include "rasters/gdal_source.h"

#include <cpl_vsi.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "rasters/raster_folder.h"
#include "rasters/tile_dataset.h"
#include "rasters/tile_finder.h"

namespace nepho {

namespace {

constexpr int kLargestWeatherTile = 4096;
/// Pictures are warped to pixels half as large as theirs: at their own size the second interpolation, from these pixels
/// to a place, would blur what the first one left.
constexpr uint32_t kFinerLevels = 1;

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

/// Of tiles nothing cheap tells whether one has changed.
std::string fingerprint_of(const std::string& stamp, RasterUse use, const RasterReading& how) {
  return fmt::format("{} {} scale {} code {} stretch {} {} opacity {} zoom {} {}", stamp, static_cast<int>(use),
                     how.vertical_scale, how.encoding, how.stretch,
                     how.black_white ? fmt::format("{}:{}", (*how.black_white)[0], (*how.black_white)[1]) : "auto",
                     how.opacity, how.min_zoom, how.max_zoom);
}

/// What `path` is: `dataset` or `tiles` of each of its sources.
std::vector<GdalSource> find_out(const std::string& path, RasterUse use, const RasterReading& how,
                                 const GdalMessages& messages) {
  GdalSource source;
  source.path = source.dataset = path;
  source.use = use;
  source.fingerprint = fingerprint_of(stamp_of(path), use, how);
  const bool ground = use == RasterUse::elevation || use == RasterUse::imagery;
  if (ground && is_tile_template(path)) {
    source.tiles = find_tiles(path, path, how, use == RasterUse::elevation, messages);
  } else if (ground && is_folder(path)) {
    std::string folder = path;
    while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
    if (const std::optional<std::string> tiles = tile_template_of_folder(folder)) {
      source.tiles = find_tiles(path, *tiles, how, use == RasterUse::elevation, messages);
    } else if (!gdal_opens(path)) {
      std::vector<GdalSource> sources;
      for (const RasterMosaic& mosaic : mosaics_of_folder(folder, use == RasterUse::elevation, messages)) {
        std::string stamps;
        for (const std::string& file : mosaic.files) stamps += file + stamp_of(file) + "\n";
        source.path = mosaic.files.size() == 1 ? mosaic.files[0] : path;
        source.dataset = mosaic.name;
        source.fingerprint = fingerprint_of(std::to_string(std::hash<std::string>()(stamps)), use, how);
        sources.push_back(source);
      }
      return sources;
    }
  }
  return {source};
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

OpenedSource open_found(GdalSource found, const RasterReading& how) {
  const GdalMessages messages;
  OpenedSource opened{.source = std::move(found), .chain = {}};
  GdalSource& source = opened.source;
  DatasetChain& chain = opened.chain;
  const std::string& path = source.path;
  const RasterUse use = source.use;
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
                            use == RasterUse::weather, use == RasterUse::imagery ? kFinerLevels : 0);
    source.layout.finer_levels = source.warp->finer_levels;
    push_warped(chain, source, messages);
    grid = source.warp->grid;
    // As the warper was asked for.
    plan.alpha = use == RasterUse::elevation ? 0 : chain.levels.front().dataset->GetRasterCount();
  }
  settle_layout(source, *grid, how, root);
  return opened;
}

/// Pictures of a folder that are not 8 bits become black and white at the same numbers.
void stretch_alike(std::vector<OpenedSource>& opened) {
  double black = 0.0, white = 0.0;
  const auto visit = [&](auto&& change) {
    for (OpenedSource& part : opened)
      if (BandPlan& plan = part.source.layout.plan;
          plan.palette.empty() && part.chain.datasets.front()->GetRasterBand(1)->GetRasterDataType() != GDT_Byte)
        change(plan);
  };
  bool any = false;
  visit([&](const BandPlan& plan) {
    const double low = -plan.offset / plan.scale, high = low + 255.0 / plan.scale;
    black = any ? std::min(black, low) : low;
    white = any ? std::max(white, high) : high;
    any = true;
  });
  visit([&](BandPlan& plan) {
    plan.scale = 255.0 / (white - black);
    plan.offset = -black * plan.scale;
  });
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

std::vector<OpenedSource> open_sources(const std::string& path, RasterUse use, const RasterReading& how) {
  init_gdal();
  set_network_timeout(how.timeout_s);
  refuse_pipes(path);
  std::vector<GdalSource> found;
  {
    const GdalMessages messages;
    found = find_out(path, use, how, messages);
  }
  const size_t parts = found.size();
  std::vector<OpenedSource> opened;
  for (GdalSource& source : found) try {
      opened.push_back(open_found(std::move(source), how));
    } catch (const Error& e) {
      if (parts == 1 || e.kind() != ErrorKind::input || (&source == &found.back() && opened.empty())) throw;
      log_warning("{}; left out of its folder", e.what());
    }
  if (use == RasterUse::imagery && opened.size() > 1) stretch_alike(opened);
  return opened;
}

}  // namespace nepho
