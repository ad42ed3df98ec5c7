#include "atmosphere/atmosphere_cache.h"

#include <doctest/doctest.h>

#include <array>
#include <cstdlib>

#include "io/file_test_tools.h"

using namespace nepho;

namespace {

std::vector<std::vector<std::byte>> two_blocks() {
  std::vector<std::vector<std::byte>> blocks(2);
  for (int i = 0; i < 1001; ++i) blocks[0].push_back(static_cast<std::byte>(i * 7));
  for (int i = 0; i < 64; ++i) blocks[1].push_back(static_cast<std::byte>(i));
  return blocks;
}
const std::array<size_t, 2> kSizes{1001, 64};

}  // namespace

TEST_CASE("cached blocks come back as they were, and not for another key, device or sizes") {
  const test::TempFolder folder;
  setenv("NEPHO_CACHE", folder.path().c_str(), 1);
  CHECK_FALSE(load_cached_blocks("a.bin", 42, 7, kSizes).has_value());
  save_cached_blocks("a.bin", 42, 7, two_blocks());
  const auto loaded = load_cached_blocks("a.bin", 42, 7, kSizes);
  REQUIRE(loaded.has_value());
  CHECK(*loaded == two_blocks());
  CHECK_FALSE(load_cached_blocks("a.bin", 43, 7, kSizes).has_value());
  CHECK_FALSE(load_cached_blocks("a.bin", 42, 8, kSizes).has_value());
  CHECK_FALSE(load_cached_blocks("a.bin", 42, 7, std::array<size_t, 2>{1001, 65}).has_value());
  CHECK_FALSE(load_cached_blocks("a.bin", 42, 7, std::array<size_t, 2>{1000, 65}).has_value());
  CHECK_FALSE(load_cached_blocks("a.bin", 42, 7, std::array<size_t, 1>{1065}).has_value());
}
