#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

namespace nepho {

/// Writes an 8-bit sRGB picture (sRGB chunk included): width * height * 3 values, row 0 on top. Whole or not at all;
/// the same picture gives the same bytes. Throws Error(failure) with the path when it cannot be written.
void write_png(const std::filesystem::path& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb);

}  // namespace nepho
