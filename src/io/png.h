#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

#include "io/image_buffer.h"

namespace nepho {

/// Writes an 8-bit sRGB picture (sRGB chunk included): width * height * 3 values, row 0 on top. Whole or not at all;
/// the same picture gives the same bytes. Throws Error(failure) with the path when it cannot be written.
void write_png(const std::filesystem::path& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb);

/// Reads any PNG, 8 or 16 bits: channels Y, Y A, R G B or R G B A (palettes expanded) of values 0..1 as they are
/// stored, with no colour space applied: pictures that hold data. Throws Error(input) with the path: missing, no PNG,
/// cut off.
ImageBuffer read_png(const std::filesystem::path& path);

}  // namespace nepho
