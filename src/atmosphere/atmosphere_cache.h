#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace nepho {

/// 64-bit FNV-1a over bytes, continued from `seed`.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0xcbf29ce484222325ull);

/// Several blocks of bytes as one file of the cache (base/blob_cache.h), by its rules for name, key and device.
///
/// Reads the blocks if they are there, whole, and of exactly these sizes.
std::optional<std::vector<std::vector<std::byte>>> load_cached_blocks(const std::string& name, uint64_t key,
                                                                      uint64_t device, std::span<const size_t> sizes);
/// Writes them, whole or not at all.
void save_cached_blocks(const std::string& name, uint64_t key, uint64_t device,
                        std::span<const std::vector<std::byte>> blocks);

}  // namespace nepho
