#include "rasters/band_plan.h"

#include <cpl_string.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/error.h"

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

void require_real_numbers(GDALDataset& dataset, const std::string& path) {
  for (int band = 1; band <= dataset.GetRasterCount(); ++band)
    if (GDALDataTypeIsComplex(dataset.GetRasterBand(band)->GetRasterDataType()))
      throw fail(ErrorKind::input, "{}: band {} holds complex numbers; give real ones", path, band);
}

bool is_alpha(GDALDataset& dataset, int band) {
  return dataset.GetRasterBand(band)->GetColorInterpretation() == GCI_AlphaBand;
}

double alpha_max_of(GDALRasterBand& band) {
  switch (band.GetRasterDataType()) {
    case GDT_Byte:
      return 255.0;
    case GDT_UInt16:
      return 65535.0;
    case GDT_Int16:
      return 32767.0;
    default:
      return 1.0;
  }
}

int bits_of(GDALRasterBand& band) {
  const char* text = band.GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
  return text ? std::atoi(text) : GDALGetDataTypeSizeBits(band.GetRasterDataType());
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

/// Valid numbers of a fixed sample of the colour bands, sorted.
std::vector<float> sorted_sample(GDALDataset& dataset, const std::vector<int>& bands, const std::string& path,
                                 const GdalMessages& messages, int side = 512) {
  const int width = std::min(side, dataset.GetRasterXSize()), height = std::min(side, dataset.GetRasterYSize());
  std::vector<float> values(size_t(width) * size_t(height)), sample;
  std::vector<uint8_t> mask(values.size());
  for (const int number : bands) {
    GDALRasterBand& band = *dataset.GetRasterBand(number);
    if (band.RasterIO(GF_Read, 0, 0, dataset.GetRasterXSize(), dataset.GetRasterYSize(), values.data(), width, height,
                      GDT_Float32, 0, 0, nullptr) != CE_None ||
        band.GetMaskBand()->RasterIO(GF_Read, 0, 0, dataset.GetRasterXSize(), dataset.GetRasterYSize(), mask.data(),
                                     width, height, GDT_Byte, 0, 0, nullptr) != CE_None)
      throw fail(ErrorKind::input, "{}: is cut off or damaged, its pixels cannot be read{}", path,
                 messages.in_brackets());
    for (size_t i = 0; i < values.size(); ++i)
      if (mask[i] && std::isfinite(values[i])) sample.push_back(values[i]);
  }
  std::sort(sample.begin(), sample.end());
  return sample;
}

/// Raw numbers `low` and `high` become 0 and 255.
void stretch(BandPlan& plan, double low, double high) {
  if (!(high > low)) high = low + 1.0;
  plan.scale = 255.0 / (high - low);
  plan.offset = -low * plan.scale;
}

bool is_palette(GDALRasterBand& band) {
  return band.GetColorInterpretation() == GCI_PaletteIndex && band.GetColorTable() != nullptr;
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
  std::array<int, 3> rgb{};
  for (int b = 1; b <= bands; ++b) {
    const GDALColorInterp meaning = dataset.GetRasterBand(b)->GetColorInterpretation();
    if (meaning == GCI_RedBand) rgb[0] = b;
    if (meaning == GCI_GreenBand) rgb[1] = b;
    if (meaning == GCI_BlueBand) rgb[2] = b;
    if (meaning == GCI_AlphaBand) plan.alpha = b;
  }
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
  std::array<int, 3> rgb = {1, 2, 3};
  for (int b = 1; b <= bands; ++b) {
    const GDALColorInterp meaning = dataset.GetRasterBand(b)->GetColorInterpretation();
    if (meaning == GCI_RedBand) rgb[0] = b;
    if (meaning == GCI_GreenBand) rgb[1] = b;
    if (meaning == GCI_BlueBand) rgb[2] = b;
  }
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
