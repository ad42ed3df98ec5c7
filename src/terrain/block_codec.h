#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// A block as bytes of a file: a header with the format's version, the key, sizes and a checksum of all that follows,
/// then the numbers, as bytes or 16-bit integers where they are such, byte planes apart, and the validity flags,
/// compressed with zlib. Lossless, NaN payloads and signed zeros included.
std::vector<std::byte> encode_block(const RasterBlock& block, uint32_t bands, const std::string& key);

/// What encode_block() was given; nothing when the bytes are not exactly that, or belong to another key.
std::optional<RasterBlock> decode_block(std::span<const std::byte> bytes, uint32_t bands, const std::string& key);

}  // namespace nepho
