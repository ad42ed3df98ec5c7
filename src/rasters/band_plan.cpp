#include "rasters/band_plan.h"

#include <cpl_string.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "rasters/band_tools.h"

namespace nepho {

namespace {

/// Metres per unit of a band's unit name; 1 for names that say nothing about length.
double metres_per(std::string unit) {
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (unit == "ft" || unit == "foot" || unit == "feet" || unit == "international foot") return 0.3048;
  if (unit == "us-ft" || unit == "us survey foot" || unit == "foot_us" || unit == "ftus") return 1200.0 / 3937.0;
  if (unit == "cm" || unit == "centimetre" || unit == "centimeter") return 0.01;
  if (unit == "dm" || unit == "decimetre" || unit == "decimeter") return 0.1;
  if (unit == "km" || unit == "kilometre" || unit == "kilometer") return 1000.0;
  return 1.0;
}

/// The largest number of a band's data type, or 1 of floating point: white without a stretch.
double full_range(GDALRasterBand& band) {
  switch (band.GetRasterDataType()) {
    case GDT_Byte:
    case GDT_UInt16:
    case GDT_UInt32:
      return std::ldexp(1.0, bits_of(band)) - 1.0;
    case GDT_Int16:
    case GDT_Int32:
      return std::ldexp(1.0, bits_of(band) - 1) - 1.0;
    default:
      return 1.0;
  }
}

/// Raw numbers `low` and `high` become 0 and 255.
void stretch(BandPlan& plan, double low, double high) {
  if (!(high > low)) high = low + 1.0;
  plan.scale = 255.0 / (high - low);
  plan.offset = -low * plan.scale;
}

/// The colours of a band of indices; the index without data is transparent.
GDALColorTable visible_palette(GDALRasterBand& band) {
  GDALColorTable colors = *band.GetColorTable();
  int has_nodata = FALSE;
  const double nodata = band.GetNoDataValue(&has_nodata);
  if (has_nodata && nodata >= 0 && nodata < colors.GetColorEntryCount()) {
    GDALColorEntry entry = *colors.GetColorEntry(static_cast<int>(nodata));
    entry.c4 = 0;
    colors.SetColorEntry(static_cast<int>(nodata), &entry);
  }
  return colors;
}

GDALDatasetUniquePtr translated(GDALDataset& source, std::initializer_list<const char*> words) {
  CPLStringList args;
  for (const char* word : words) args.AddString(word);
  std::unique_ptr<GDALTranslateOptions, decltype(&GDALTranslateOptionsFree)> options(
      GDALTranslateOptionsNew(args.List(), nullptr), &GDALTranslateOptionsFree);
  int misuse = FALSE;
  return GDALDatasetUniquePtr(
      GDALDataset::FromHandle(GDALTranslate("", GDALDataset::ToHandle(&source), options.get(), &misuse)));
}

}  // namespace

BandPlan plan_elevation(GDALDataset& dataset, const std::string& path) {
  require_real_numbers(dataset, path);
  const int bands = dataset.GetRasterCount();
  BandPlan plan;
  plan.elevation = true;
  plan.colors = {1};
  if (bands == 2 && is_alpha(dataset, 2)) {
    plan.alpha = 2;
    plan.alpha_max = alpha_max_of(*dataset.GetRasterBand(2));
  } else if (bands != 1) {
    throw fail(ErrorKind::input, "{}: has {} bands, elevation has one; gdal_translate -b N takes one out{}", path,
               bands, bands == 3 || bands == 4 ? "; where its colours are heights, encoding=terrarium or mapbox" : "");
  }
  GDALRasterBand& band = *dataset.GetRasterBand(1);
  if (band.GetColorInterpretation() == GCI_PaletteIndex)
    throw fail(ErrorKind::input, "{}: is a palette picture, not elevation", path);
  const double metres = metres_per(band.GetUnitType());
  plan.scale = band.GetScale() * metres;
  plan.offset = band.GetOffset() * metres;
  return plan;
}

BandPlan plan_imagery(GDALDataset& dataset, const std::string& path, const RasterReading& how,
                      const GdalMessages& messages) {
  require_real_numbers(dataset, path);
  const int bands = dataset.GetRasterCount();
  BandPlan plan;
  const std::array<int, 3> rgb = rgb_bands(dataset);
  for (int b = 1; b <= bands; ++b)
    if (is_alpha(dataset, b)) plan.alpha = b;
  const int colors = bands - (plan.alpha ? 1 : 0);
  if (bands > 4 || (colors != 1 && colors != 3 && colors != 4))
    throw fail(
        ErrorKind::input,
        "{}: has {} bands{}; a picture is grey or RGB, with or without alpha; gdal_translate -b R -b G -b B takes "
        "some out",
        path, bands, plan.alpha ? ", one of them alpha" : "");
  if (is_palette(*dataset.GetRasterBand(1))) {
    if (bands > 1) throw fail(ErrorKind::input, "{}: mixes a palette with {} further bands", path, bands - 1);
    plan.colors = {1};
    const GDALColorTable colors_of = visible_palette(*dataset.GetRasterBand(1));
    for (int i = 0; i < colors_of.GetColorEntryCount(); ++i) {
      GDALColorEntry entry{};
      colors_of.GetColorEntryAsRGB(i, &entry);
      plan.palette.push_back({float(entry.c1), float(entry.c2), float(entry.c3), float(entry.c4)});
    }
    return plan;
  }
  if (plan.alpha && plan.alpha != bands)
    throw fail(ErrorKind::input, "{}: band {} is alpha; it must be the last one", path, plan.alpha);
  if (colors == 1)
    plan.colors = {1};
  else if (rgb[0] && rgb[1] && rgb[2])
    plan.colors.assign(rgb.begin(), rgb.end());
  else
    plan.colors = {1, 2, 3};
  if (plan.alpha) plan.alpha_max = alpha_max_of(*dataset.GetRasterBand(plan.alpha));

  GDALRasterBand& first = *dataset.GetRasterBand(plan.colors[0]);
  const int bits = bits_of(first);
  const std::string driver = dataset.GetDriver() ? dataset.GetDriverName() : "";
  if (how.black_white) {
    stretch(plan, (*how.black_white)[0], (*how.black_white)[1]);
  } else if (first.GetRasterDataType() == GDT_Byte || (driver == "PNG" && bits == 16)) {
    stretch(plan, 0.0, std::ldexp(1.0, bits) - 1.0);
  } else if (!how.stretch) {
    stretch(plan, 0.0, full_range(first));
  } else {
    const std::vector<float> sample = sorted_sample(dataset, plan.colors, path, messages);
    if (sample.empty()) return plan;  // nothing valid in the sample: keep the numbers
    const auto percentile = [&](double share) {
      return static_cast<double>(sample[static_cast<size_t>(share * static_cast<double>(sample.size() - 1))]);
    };
    stretch(plan, percentile(0.01), percentile(0.99));
  }
  return plan;
}

std::vector<GDALDatasetUniquePtr> expand_palette(GDALDataset& source, const std::string& path) {
  std::vector<GDALDatasetUniquePtr> chain;
  const GDALColorTable colors = visible_palette(*source.GetRasterBand(1));
  chain.push_back(translated(source, {"-of", "VRT", "-a_nodata", "none"}));
  if (chain.back() && chain.back()->GetRasterBand(1)->SetColorTable(const_cast<GDALColorTable*>(&colors)) == CE_None)
    chain.push_back(translated(*chain.back(), {"-of", "VRT", "-expand", "rgba"}));
  if (!chain.back() || chain.back()->GetRasterCount() != 4)
    throw fail(ErrorKind::input, "{}: its palette cannot be expanded to colours", path);
  return chain;
}

}  // namespace nepho
