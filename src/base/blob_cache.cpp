#include "base/blob_cache.h"

#include <cstring>
#include <fstream>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"

namespace nepho {
namespace {

struct Header {
  char magic[8] = {'N', 'E', 'P', 'H', 'B', 'L', 'B', '2'};
  uint64_t key = 0;
  uint64_t device = 0;
  uint64_t size = 0;
  uint64_t checksum = 0;
};

/// The bytes of a file, where `accept` takes its header and they are whole.
template <typename F>
std::optional<std::vector<std::byte>> load(const std::filesystem::path& path, F accept) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  Header header;
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return std::nullopt;
  if (std::memcmp(header.magic, Header{}.magic, sizeof header.magic) != 0 || !accept(header)) return std::nullopt;
  if (header.size > (1ull << 30)) return std::nullopt;
  std::vector<std::byte> bytes(header.size);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    return std::nullopt;
  if (file.peek() != std::ifstream::traits_type::eof()) return std::nullopt;
  if (checksum_of(bytes.data(), bytes.size()) != header.checksum) return std::nullopt;
  return bytes;
}

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

std::optional<std::vector<std::byte>> load_cached_blob(const std::string& name, uint64_t key, uint64_t device) {
  if (const std::filesystem::path folder = cache_dir(); !folder.empty())
    if (auto own = load(folder / name, [&](const Header& h) { return h.key == key && h.device == device; })) return own;
  return load(data_dir() / "tables" / name, [&](const Header& h) { return h.key == key; });
}

void store_cached_blob(const std::string& name, uint64_t key, const std::vector<std::byte>& bytes, uint64_t device) {
  const std::filesystem::path folder = cache_dir();
  if (folder.empty()) return;
  Header header;
  header.key = key;
  header.device = device;
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
