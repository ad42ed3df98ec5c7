#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nepho {

/// Bytes kept in cache_dir() under `name`; they may vanish at any time. Loading gives nothing unless key, length and
/// checksum agree, so an old version, a torn file or a flipped bit means "make it again", never a wrong picture.
std::optional<std::vector<std::byte>> load_cached_blob(const std::string& name, uint64_t key);

/// Writes whole or not at all; a folder that cannot be written costs time on the next start, nothing else.
void store_cached_blob(const std::string& name, uint64_t key, const std::vector<std::byte>& bytes);

/// 64-bit checksum of bytes (FNV-1a over words, folded).
uint64_t checksum_of(const std::byte* bytes, size_t count);

}  // namespace nepho
