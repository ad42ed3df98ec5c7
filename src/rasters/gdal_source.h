#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/raster.h"
#include "rasters/dataset_handle.h"
#include "rasters/height_colours.h"
#include "rasters/tile_names.h"
#include "rasters/warp_plan.h"

namespace nepho {

/// What a raster is opened as.
enum class RasterUse { elevation, imagery, weather, weather_tile };

/// A name that a user gave, understood: how to open it once more, with every decision taken at the first look.
struct GdalSource {
  std::string path;  ///< as the user named it, or the one file of a folder: what messages name
  RasterUse use = RasterUse::elevation;
  std::string dataset;           ///< what GDAL opens
  std::optional<TileSet> tiles;  ///< instead of `dataset`
  HeightCode code = HeightCode::none;
  bool expand_palette = false;
  std::optional<WarpPlan> warp;
  RasterLayout layout;
  VerticalDatum vertical = VerticalDatum::egm96;
  size_t most_openings = 1;
  std::string fingerprint;  ///< RasterInfo's

  /// Opens it again. Throws Error(input).
  DatasetChain open() const;
};

struct OpenedSource {
  GdalSource source;
  DatasetChain chain;
};

/// Finds out what `path` is (a file, a folder of rasters or of tiles, a template of tiles, a GDAL connection) and opens
/// it: one source, or, of a folder, one for each of its mosaics, bottom first. Throws Error(input), one line.
std::vector<OpenedSource> open_sources(const std::string& path, RasterUse use, const RasterReading& how);

}  // namespace nepho
