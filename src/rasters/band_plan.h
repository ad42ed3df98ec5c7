#pragma once
#include <array>
#include <vector>

#include "rasters/gdal_support.h"

namespace nepho {

/// Which bands of a dataset make the picture or the heights, and what turns their numbers into ours.
struct BandPlan {
  bool elevation = false;
  std::vector<int> colors;   ///< dataset bands of value: 1 for elevation and grey, 3 for RGB
  int alpha = 0;             ///< dataset band, 0 for none
  double alpha_max = 255.0;  ///< alpha value of an opaque pixel
  double scale = 1.0;        ///< delivered value = raw * scale + offset: metres, or 0..255
  double offset = 0.0;
  std::vector<std::array<float, 4>> palette;  ///< RGBA 0..255 by index, where the one band of `colors` holds indices
};

/// Heights in metres of a dataset with one band (and perhaps alpha). Units (feet), scale and offset of the band count.
/// Throws Error(input) for pictures and several bands.
BandPlan plan_elevation(GDALDataset& dataset, const std::string& path);

/// Grey, grey + alpha, RGB or RGBA (or four bands, the first three of them the picture); what is not 8 bits is
/// stretched so that the 1st and 99th percentile of a sample of it become 0 and 255 (16-bit PNG: its full range).
/// A palette stays indices here, with the index of "no data" transparent. Throws Error(input) for other numbers of
/// bands.
BandPlan plan_imagery(GDALDataset& dataset, const std::string& path, const GdalMessages& messages);

/// A palette picture as RGBA, so that it can be warped: the last of the datasets, each of which needs the one before.
std::vector<GDALDatasetUniquePtr> expand_palette(GDALDataset& source, const std::string& path);

}  // namespace nepho
