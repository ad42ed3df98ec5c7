// plan_weather(): which bands of a dataset are cloud cover.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "rasters/band_plan.h"
#include "rasters/band_tools.h"

namespace nepho {

namespace {

/// A picture in grey has the same in all three bands, but for what JPEG makes of it.
bool is_grey(GDALDataset& dataset, const std::array<int, 3>& rgb, const std::string& path,
             const GdalMessages& messages) {
  constexpr int kSide = 512;
  const int width = std::min(kSide, dataset.GetRasterXSize()), height = std::min(kSide, dataset.GetRasterYSize());
  std::array<std::vector<float>, 3> bands;
  for (size_t b = 0; b < 3; ++b) {
    bands[b].resize(size_t(width) * size_t(height));
    if (dataset.GetRasterBand(rgb[b])->RasterIO(GF_Read, 0, 0, dataset.GetRasterXSize(), dataset.GetRasterYSize(),
                                                bands[b].data(), width, height, GDT_Float32, 0, 0, nullptr) != CE_None)
      throw fail(ErrorKind::input, "{}: is cut off or damaged, its pixels cannot be read{}", path,
                 messages.in_brackets());
  }
  double colour = 0.0, largest = 0.0;
  for (size_t i = 0; i < bands[0].size(); ++i) {
    const auto [low, high] = std::minmax({bands[0][i], bands[1][i], bands[2][i]});
    colour += static_cast<double>(high - low);
    largest = std::max(largest, static_cast<double>(high));
  }
  constexpr double kMostColour = 0.02;
  return colour <= kMostColour * largest * static_cast<double>(bands[0].size());
}

/// What makes cover 0..1 of raw numbers: full range for pictures, else fractions or percent by the range found.
void scale_cover(BandPlan& plan, GDALDataset& dataset, const std::string& path, const GdalMessages& messages) {
  GDALRasterBand& first = *dataset.GetRasterBand(plan.colors[0]);
  const GDALDataType type = first.GetRasterDataType();
  const double band_scale = first.GetScale(), band_offset = first.GetOffset();
  const bool packed = band_scale != 1.0 || band_offset != 0.0;
  const std::string unit = first.GetUnitType();
  const bool percent = unit == "%" || unit == "percent";
  if (type == GDT_Byte && !packed && !percent) {
    plan.scale = 1.0 / (std::ldexp(1.0, bits_of(first)) - 1.0);
    return;
  }
  std::vector<int> values = plan.colors;
  if (plan.opacity_scale > 0.0) values.pop_back();
  const std::vector<float> sample = sorted_sample(dataset, values, path, messages, 2048);
  const double low = sample.empty() ? 0.0 : static_cast<double>(sample.front()) * band_scale + band_offset;
  const double high = sample.empty() ? 0.0 : static_cast<double>(sample.back()) * band_scale + band_offset;
  if (type == GDT_UInt16 && !packed && !percent && high > 100.0) {
    plan.scale = 1.0 / 65535.0;
    return;
  }
  const bool fraction = low >= -0.005 && high <= 1.005;
  if (!fraction && (low < -0.5 || high > 100.5))
    throw fail(ErrorKind::input,
               "{}: values from {:.6g} to {:.6g} are no cloud cover; it is 0..1, 0..100 percent, or a picture of 8 or "
               "16 bits; gdal_calc.py or gdal_translate -scale makes one of it",
               path, low, high);
  const double to_cover = fraction ? 1.0 : 0.01;
  plan.scale = band_scale * to_cover;
  plan.offset = band_offset * to_cover;
}

}  // namespace

BandPlan plan_weather(GDALDataset& dataset, const std::string& path, const GdalMessages& messages) {
  require_real_numbers(dataset, path);
  const int bands = dataset.GetRasterCount();
  BandPlan plan;
  if (is_palette(*dataset.GetRasterBand(1))) {
    if (bands > 1) throw fail(ErrorKind::input, "{}: mixes a palette with {} further bands", path, bands - 1);
    plan.colors = {1};
    GDALRasterBand& band = *dataset.GetRasterBand(1);
    const GDALColorTable& colors = *band.GetColorTable();
    int has_nodata = FALSE;
    const double nodata = band.GetNoDataValue(&has_nodata);
    bool grey = true;
    for (int i = 0; i < colors.GetColorEntryCount(); ++i) {
      GDALColorEntry e{};
      colors.GetColorEntryAsRGB(i, &e);
      grey = grey && (e.c4 == 0 || (std::abs(e.c1 - e.c2) < 8 && std::abs(e.c2 - e.c3) < 8));
      plan.palette.push_back({float(e.c1) / 255.0f, float(e.c2) / 255.0f, float(e.c3) / 255.0f, float(e.c4) / 255.0f});
      if (has_nodata && nodata == i) plan.palette.back().fill(std::numeric_limits<float>::quiet_NaN());
    }
    plan.weather = grey ? 1 : 4;
    if (grey)
      for (std::array<float, 4>& entry : plan.palette) entry[0] *= entry[3];
    return plan;
  }
  const int alpha = is_alpha(dataset, bands) ? bands : 0;
  const int colors = bands - (alpha ? 1 : 0);
  if (bands > 4 || colors == 0 || colors == 2)
    throw fail(ErrorKind::input,
               "{}: has {} bands; weather has one of cloud cover, or RGB or RGBA; gdal_translate -b N takes one out",
               path, bands);
  std::array<int, 3> rgb = rgb_bands(dataset);
  for (int b = 0; b < 3; ++b)
    if (rgb[static_cast<size_t>(b)] == 0) rgb[static_cast<size_t>(b)] = b + 1;
  const bool total = colors == 1 || (colors == 3 && is_grey(dataset, rgb, path, messages));
  plan.weather = total ? 1 : 4;
  if (colors == 1)
    plan.colors = {1};
  else if (total)
    plan.colors = {rgb[1]};
  else
    plan.colors.assign(rgb.begin(), rgb.end());
  if (total && alpha) plan.opacity_scale = 1.0 / alpha_max_of(*dataset.GetRasterBand(alpha));
  if (alpha || bands == 4) plan.colors.push_back(4 <= bands ? 4 : alpha);
  scale_cover(plan, dataset, path, messages);
  return plan;
}

}  // namespace nepho
