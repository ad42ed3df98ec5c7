#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nepho {

/// Bytes kept in cache_dir() under `name`; they may vanish at any time. Loading gives nothing unless key, device,
/// length and checksum agree, so an old version, a torn file or a flipped bit means "make it again", never a wrong
/// picture.
///
/// `device`: a hash of the device and driver that made the bytes, where those round in their own way; 0: all make the
/// same. Files that came with a packaged program (data_dir()/tables, docs/packaging.md) serve every device: they are
/// used where cache_dir() has none.
std::optional<std::vector<std::byte>> load_cached_blob(const std::string& name, uint64_t key, uint64_t device = 0);

/// Writes whole or not at all; a folder that cannot be written costs time on the next start, nothing else.
void store_cached_blob(const std::string& name, uint64_t key, const std::vector<std::byte>& bytes, uint64_t device = 0);

/// 64-bit checksum of bytes (FNV-1a over words, folded).
uint64_t checksum_of(const std::byte* bytes, size_t count);

}  // namespace nepho
