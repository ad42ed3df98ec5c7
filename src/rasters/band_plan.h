#pragma once
#include <array>
#include <vector>

#include "io/raster.h"
#include "rasters/gdal_support.h"

namespace nepho {

/// Which bands of a dataset make the picture or the heights, and what turns their numbers into ours.
struct BandPlan {
  bool elevation = false;
  int weather = 0;           ///< values per pixel of weather, 1 or 4; 0: no weather
  std::vector<int> colors;   ///< dataset bands of value: 1 for elevation and grey, 3 for RGB; for weather 1 to 4
  int alpha = 0;             ///< dataset band, 0 for none
  double alpha_max = 255.0;  ///< alpha value of an opaque pixel
  /// Weather: the last of `colors` is an opacity; delivered is grey times raw opacity times this. 0: none.
  double opacity_scale = 0.0;
  double scale = 1.0;  ///< delivered value = raw * scale + offset: metres, 0..255, or 0..1 for weather
  double offset = 0.0;
  double exaggeration = 1.0;  ///< elevation: multiplies heights that were found good
  double opacity = 1.0;       ///< imagery: multiplies alpha
  /// By index, where the one band of `colors` holds indices: RGBA 0..255, or the values of weather (NaN: no data).
  std::vector<std::array<float, 4>> palette;
};

/// Heights in metres of a dataset with one band (and perhaps alpha). Units (feet), scale and offset of the band count.
/// Throws Error(input) for pictures and several bands.
BandPlan plan_elevation(GDALDataset& dataset, const std::string& path);

/// Grey, grey + alpha, RGB or RGBA (or four bands, the first three of them the picture); what is not 8 bits is
/// stretched so that the 1st and 99th percentile of a sample of it become 0 and 255 (16-bit PNG: its full range), or as
/// `how` says.
/// A palette stays indices here, with the index of "no data" transparent. Throws Error(input) for other numbers of
/// bands.
BandPlan plan_imagery(GDALDataset& dataset, const std::string& path, const RasterReading& how,
                      const GdalMessages& messages);

/// Cloud cover by the rules of docs/weather.md. Throws Error(input) for numbers that are no cover and for other numbers
/// of bands.
BandPlan plan_weather(GDALDataset& dataset, const std::string& path, const GdalMessages& messages);

/// A palette picture as RGBA, so that it can be warped: the last of the datasets, each of which needs the one before.
std::vector<GDALDatasetUniquePtr> expand_palette(GDALDataset& source, const std::string& path);

}  // namespace nepho
