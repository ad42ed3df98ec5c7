#include "atmosphere/atmosphere_cache.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>

#include "base/files.h"

using namespace nepho;

namespace {

struct TemporaryFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("nepho_atmosphere_cache_" + std::to_string(::getpid()) + ".bin");
  ~TemporaryFile() { std::filesystem::remove(path); }
};

std::vector<std::vector<std::byte>> two_blocks() {
  std::vector<std::vector<std::byte>> blocks(2);
  for (int i = 0; i < 1001; ++i) blocks[0].push_back(static_cast<std::byte>(i * 7));
  for (int i = 0; i < 64; ++i) blocks[1].push_back(static_cast<std::byte>(i));
  return blocks;
}
const std::array<size_t, 2> kSizes{1001, 64};

}  // namespace

TEST_CASE("cached blocks come back as they were") {
  TemporaryFile file;
  REQUIRE(save_cached_blocks(file.path, 42, two_blocks()));
  const auto loaded = load_cached_blocks(file.path, 42, kSizes);
  REQUIRE(loaded.has_value());
  CHECK(*loaded == two_blocks());
}

TEST_CASE("a cache file that is missing, of another key or size, cut short or damaged is not used") {
  TemporaryFile file;
  CHECK_FALSE(load_cached_blocks(file.path, 42, kSizes).has_value());
  REQUIRE(save_cached_blocks(file.path, 42, two_blocks()));
  CHECK_FALSE(load_cached_blocks(file.path, 43, kSizes).has_value());
  CHECK_FALSE(load_cached_blocks(file.path, 42, std::array<size_t, 2>{1001, 65}).has_value());
  CHECK_FALSE(load_cached_blocks(file.path, 42, std::array<size_t, 1>{1065}).has_value());
  std::string bytes = read_text_file(file.path);
  const auto write = [&](const std::string& text) { std::ofstream(file.path, std::ios::binary) << text; };
  write(bytes.substr(0, bytes.size() - 1));
  CHECK_FALSE(load_cached_blocks(file.path, 42, kSizes).has_value());
  for (const size_t at : {size_t{0}, size_t{50}, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write(damaged);
    CHECK_FALSE(load_cached_blocks(file.path, 42, kSizes).has_value());
  }
  write("not a cache");
  CHECK_FALSE(load_cached_blocks(file.path, 42, kSizes).has_value());
}

TEST_CASE("a cache that cannot be written is no error") {
  CHECK_FALSE(save_cached_blocks("/no/such/folder/tables.bin", 1, two_blocks()));
}
