#include "atmosphere/atmosphere_cache.h"

#include <cstring>
#include <fstream>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"

namespace nepho {

namespace {
struct Header {
  char magic[8] = {'N', 'E', 'P', 'H', 'O', 'A', 'T', '1'};
  uint64_t key = 0;
  uint64_t block_count = 0;
  uint64_t payload_bytes = 0;
  uint64_t checksum = 0;  // of the payload
};
static_assert(sizeof(Header) == 40);

uint64_t checksum_of(std::span<const std::byte> bytes) {
  // Eight bytes at a time: tens of megabytes must take milliseconds.
  uint64_t sum = 0xcbf29ce484222325ull;
  size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    uint64_t word;
    std::memcpy(&word, bytes.data() + i, 8);
    sum = (sum ^ word) * 0x100000001b3ull;
    sum ^= sum >> 29;
  }
  return hash_bytes(bytes.subspan(i), sum);
}
}  // namespace

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
  for (const std::byte b : bytes) seed = (seed ^ static_cast<uint64_t>(b)) * 0x100000001b3ull;
  return seed;
}

std::optional<std::vector<std::vector<std::byte>>> load_cached_blocks(const std::filesystem::path& file, uint64_t key,
                                                                      std::span<const size_t> sizes) {
  std::error_code ec;
  size_t expected = 0;
  for (const size_t s : sizes) expected += s;
  const auto bytes_on_disk = std::filesystem::file_size(file, ec);
  if (ec || bytes_on_disk != sizeof(Header) + expected) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  Header header;
  if (!in.read(reinterpret_cast<char*>(&header), sizeof(header))) return std::nullopt;
  if (std::memcmp(header.magic, Header{}.magic, sizeof(header.magic)) != 0 || header.key != key ||
      header.block_count != sizes.size() || header.payload_bytes != expected)
    return std::nullopt;
  std::vector<std::byte> payload(expected);
  if (!in.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(expected))) return std::nullopt;
  if (checksum_of(payload) != header.checksum) return std::nullopt;
  std::vector<std::vector<std::byte>> blocks;
  const std::byte* at = payload.data();
  for (const size_t s : sizes) {
    blocks.emplace_back(at, at + s);
    at += s;
  }
  return blocks;
}

bool save_cached_blocks(const std::filesystem::path& file, uint64_t key,
                        std::span<const std::vector<std::byte>> blocks) {
  std::vector<std::byte> payload;
  for (const auto& b : blocks) payload.insert(payload.end(), b.begin(), b.end());
  Header header;
  header.key = key;
  header.block_count = blocks.size();
  header.payload_bytes = payload.size();
  header.checksum = checksum_of(payload);
  try {
    write_whole_file(file, [&](const std::filesystem::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      out.write(reinterpret_cast<const char*>(&header), sizeof(header));
      out.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
      if (!out.flush()) throw fail(ErrorKind::failure, "{}: cannot be written", temporary.string());
    });
  } catch (const Error& e) {
    log_debug("atmosphere tables are not cached: {}", e.what());
    return false;
  }
  return true;
}

}  // namespace nepho
