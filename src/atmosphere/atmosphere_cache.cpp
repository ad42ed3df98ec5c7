#include "atmosphere/atmosphere_cache.h"

#include <numeric>

#include "base/blob_cache.h"

namespace nepho {

namespace {
/// Other sizes are another key, even where they add up to the same.
uint64_t key_of(uint64_t key, std::span<const size_t> sizes) { return hash_bytes(std::as_bytes(sizes), key); }
}  // namespace

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
  for (const std::byte b : bytes) seed = (seed ^ static_cast<uint64_t>(b)) * 0x100000001b3ull;
  return seed;
}

std::optional<std::vector<std::vector<std::byte>>> load_cached_blocks(const std::string& name, uint64_t key,
                                                                      uint64_t device, std::span<const size_t> sizes) {
  const auto blob = load_cached_blob(name, key_of(key, sizes), device);
  if (!blob || blob->size() != std::reduce(sizes.begin(), sizes.end())) return std::nullopt;
  std::vector<std::vector<std::byte>> blocks;
  const std::byte* at = blob->data();
  for (const size_t size : sizes) {
    blocks.emplace_back(at, at + size);
    at += size;
  }
  return blocks;
}

void save_cached_blocks(const std::string& name, uint64_t key, uint64_t device,
                        std::span<const std::vector<std::byte>> blocks) {
  std::vector<size_t> sizes;
  std::vector<std::byte> blob;
  for (const std::vector<std::byte>& block : blocks) {
    sizes.push_back(block.size());
    blob.insert(blob.end(), block.begin(), block.end());
  }
  store_cached_blob(name, key_of(key, sizes), blob, device);
}

}  // namespace nepho
