#pragma once
#include <array>
#include <string>
#include <vector>

#include "rasters/gdal_support.h"

namespace nepho {

/// Throws Error(input) for complex numbers.
void require_real_numbers(GDALDataset& dataset, const std::string& path);

bool is_alpha(GDALDataset& dataset, int band);

/// Alpha of an opaque pixel in a band's data type.
double alpha_max_of(GDALRasterBand& band);

/// Bits that are used of a band's numbers.
int bits_of(GDALRasterBand& band);

/// Valid numbers of a fixed sample of the colour bands, sorted.
std::vector<float> sorted_sample(GDALDataset& dataset, const std::vector<int>& bands, const std::string& path,
                                 const GdalMessages& messages, int side = 512);

bool is_palette(GDALRasterBand& band);

/// The bands that say they are red, green and blue; 0 where none does.
std::array<int, 3> rgb_bands(GDALDataset& dataset);

}  // namespace nepho
