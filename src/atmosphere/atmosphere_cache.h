#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace nepho {

/// 64-bit FNV-1a over bytes, continued from `seed`.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0xcbf29ce484222325ull);

/// Blocks of bytes under a key, in one file of the cache folder, with a checksum. Nothing here throws: a cache that
/// cannot be read or written is a cache that is not used.
///
/// Reads the blocks if the file is there, whole, ours, of this key, and has blocks of exactly these sizes.
std::optional<std::vector<std::vector<std::byte>>> load_cached_blocks(const std::filesystem::path& file, uint64_t key,
                                                                      std::span<const size_t> sizes);
/// Writes them, whole or not at all; false when that failed.
bool save_cached_blocks(const std::filesystem::path& file, uint64_t key,
                        std::span<const std::vector<std::byte>> blocks);

}  // namespace nepho
