#include "rasters/band_tools.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace nepho {

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

std::vector<float> sorted_sample(GDALDataset& dataset, const std::vector<int>& bands, const std::string& path,
                                 const GdalMessages& messages, int side) {
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

bool is_palette(GDALRasterBand& band) {
  return band.GetColorInterpretation() == GCI_PaletteIndex && band.GetColorTable() != nullptr;
}

std::array<int, 3> rgb_bands(GDALDataset& dataset) {
  std::array<int, 3> rgb{};
  for (int b = 1; b <= dataset.GetRasterCount(); ++b) {
    const GDALColorInterp meaning = dataset.GetRasterBand(b)->GetColorInterpretation();
    if (meaning == GCI_RedBand) rgb[0] = b;
    if (meaning == GCI_GreenBand) rgb[1] = b;
    if (meaning == GCI_BlueBand) rgb[2] = b;
  }
  return rgb;
}

}  // namespace nepho
