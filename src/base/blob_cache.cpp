#include "base/blob_cache.h"

#include <cstring>
#include <fstream>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"

namespace nepho {
namespace {

struct Header {
  char magic[8] = {'N', 'E', 'P', 'H', 'B', 'L', 'O', 'B'};
  uint64_t key = 0;
  uint64_t size = 0;
  uint64_t checksum = 0;
};

}  // namespace

uint64_t checksum_of(const std::byte* bytes, size_t count) {
  uint64_t h = 0xcbf29ce484222325ull ^ count;
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + i, 8);
    h = (h ^ word) * 0x100000001b3ull;
    h ^= h >> 29;
  }
  for (; i < count; ++i) h = (h ^ static_cast<uint64_t>(bytes[i])) * 0x100000001b3ull;
  return h ^ (h >> 32);
}

std::optional<std::vector<std::byte>> load_cached_blob(const std::string& name, uint64_t key) {
  const std::filesystem::path folder = cache_dir();
  if (folder.empty()) return std::nullopt;
  std::ifstream file(folder / name, std::ios::binary);
  if (!file) return std::nullopt;
  Header header;
  const Header expected;
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return std::nullopt;
  if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 || header.key != key) return std::nullopt;
  if (header.size > (1ull << 30)) return std::nullopt;
  std::vector<std::byte> bytes(header.size);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    return std::nullopt;
  if (file.peek() != std::ifstream::traits_type::eof()) return std::nullopt;
  if (checksum_of(bytes.data(), bytes.size()) != header.checksum) return std::nullopt;
  return bytes;
}

void store_cached_blob(const std::string& name, uint64_t key, const std::vector<std::byte>& bytes) {
  const std::filesystem::path folder = cache_dir();
  if (folder.empty()) return;
  Header header;
  header.key = key;
  header.size = bytes.size();
  header.checksum = checksum_of(bytes.data(), bytes.size());
  try {
    write_whole_file(folder / name, [&](const std::filesystem::path& temporary) {
      std::ofstream file(temporary, std::ios::binary);
      file.write(reinterpret_cast<const char*>(&header), sizeof header);
      file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      if (!file.flush()) throw fail(ErrorKind::failure, "{}: cannot be written", temporary.string());
    });
  } catch (const Error& error) {
    log_debug("cache: {}", error.what());
  }
}

}  // namespace nepho
