#pragma once
#include <filesystem>
#include <memory>

#include "io/raster.h"

namespace nepho {

/// Writes a raster of whole numbers (-32768..32767: heights in metres, colours) into one file of our own, without loss,
/// to be read where there is no GDAL (docs/packaging.md). The file holds its full size; RasterInfo goes with it, but
/// for the path. Throws Error(input) for other numbers and for what cannot be read, Error(failure) for the disk.
void bake_raster(const Raster& raster, const std::filesystem::path& file);

/// A raster from such a file: block by block the same bits, at reductions those of BlockAverager. Holds the compressed
/// bytes in memory. Throws Error(input) for a file that is missing, cut off, damaged or of another version.
std::shared_ptr<Raster> open_baked_raster(const std::filesystem::path& file);

}  // namespace nepho
