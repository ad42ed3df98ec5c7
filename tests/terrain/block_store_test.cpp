#include "terrain/block_store.h"

#include <doctest/doctest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include "io/file_test_tools.h"
#include "terrain/block_cache.h"
#include "terrain/block_codec.h"
#include "test_rasters.h"

using namespace nepho;
using nepho::test::PlaneRaster;
using nepho::test::TempFolder;
namespace fs = std::filesystem;

namespace {

constexpr uint64_t kMiB = 1u << 20;

RasterInfo info_of(const std::string& fingerprint, uint32_t bands = 1) {
  RasterInfo info;
  info.path = "raster.tif";
  info.width = info.height = 1000;
  info.bands = bands;
  info.fingerprint = fingerprint;
  return info;
}

/// Numbers that hardly compress.
RasterBlock noise(uint32_t seed, uint32_t side = 64) {
  RasterBlock block{.width = side, .height = side, .values = {}, .valid = {}};
  for (uint32_t i = 0; i < side * side; ++i) {
    seed = seed * 1664525u + 1013904223u;
    block.values.push_back(static_cast<float>(seed >> 8) * 0.37f);
  }
  block.valid.assign(block.values.size(), 1);
  return block;
}

bool same_bits(const RasterBlock& a, const RasterBlock& b) {
  if (a.width != b.width || a.height != b.height || a.valid != b.valid || a.values.size() != b.values.size())
    return false;
  for (size_t i = 0; i < a.values.size(); ++i)
    if (std::bit_cast<uint32_t>(a.values[i]) != std::bit_cast<uint32_t>(b.values[i])) return false;
  return true;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder))
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}

uint64_t bytes_in(const fs::path& folder) {
  uint64_t bytes = 0;
  for (const fs::path& file : files_in(folder)) bytes += fs::file_size(file);
  return bytes;
}

void save(BlockStore& store, const BlockStore::Source& source, uint32_t bx, RasterBlock block) {
  store.save(source, 0, bx, 0, std::make_shared<const RasterBlock>(std::move(block)));
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_CASE("a block comes back from its bytes bit by bit, whatever numbers it holds") {
  const float quiet_nan = std::bit_cast<float>(0x7fc12345u);
  const std::vector<std::vector<float>> kinds = {{0, 1, 255, 128, 7, 0},          // bytes
                                                 {0, -1, 32767, -32768, 256, 3},  // 16-bit integers
                                                 {0.0f, -0.0f, 1, 2, 3, 4},       // a signed zero is no integer
                                                 {1e30f, -1e-40f, quiet_nan, 0.1f, 65536.0f, -32769.0f},  // neither
                                                 {std::numeric_limits<float>::infinity(), 0, 0, 0, 0, -1e38f}};
  for (const std::vector<float>& values : kinds)
    for (const std::vector<uint8_t>& valid : {std::vector<uint8_t>{1, 1, 1}, {0, 1, 0}, {0, 0, 0}}) {
      const RasterBlock block{.width = 3, .height = 1, .values = values, .valid = valid};
      const auto bytes = encode_block(block, 2, "key");
      const auto back = decode_block(bytes, 2, "key");
      REQUIRE(back.has_value());
      CHECK(same_bits(block, *back));
      CHECK_FALSE(decode_block(bytes, 2, "kez").has_value());
      CHECK_FALSE(decode_block(bytes, 1, "key").has_value());
    }
}

TEST_CASE("whole numbers take a quarter or half of the space of others") {
  RasterBlock block = noise(1, 256);
  const size_t full = encode_block(block, 1, "").size();
  for (float& v : block.values) v = std::floor(std::fmod(v, 65536.0f)) - 32768.0f;
  const size_t half = encode_block(block, 1, "").size();
  for (float& v : block.values) v = std::floor(std::fmod(std::abs(v), 256.0f));
  const size_t quarter = encode_block(block, 1, "").size();
  CHECK(half < full * 7 / 10);
  CHECK(quarter < half * 6 / 10);
}

TEST_CASE("no cut and no flipped bit of a file is taken for a block") {
  const RasterBlock block = noise(5, 16);
  const auto good = encode_block(block, 1, "a key");
  for (size_t size = 0; size < good.size(); ++size)
    CHECK_FALSE(decode_block(std::span(good).first(size), 1, "a key").has_value());
  for (size_t bit = 0; bit < good.size() * 8; bit += 3) {
    auto bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    CHECK_FALSE(decode_block(bad, 1, "a key").has_value());
  }
  auto longer = good;
  longer.push_back(std::byte{0});
  CHECK_FALSE(decode_block(longer, 1, "a key").has_value());
}

TEST_CASE("what was saved is loaded by another store of the folder, for the same source only") {
  const TempFolder folder;
  const auto source = BlockStore::source_of(info_of("v1"));
  {
    BlockStore store(folder.path() / "blocks", 100 * kMiB);
    for (uint32_t i = 0; i < 5; ++i) save(store, source, i, noise(i));
    save(store, BlockStore::source_of(info_of("")), 0, noise(9));  // no fingerprint: not kept
  }
  CHECK(files_in(folder.path()).size() == 5);
  BlockStore store(folder.path() / "blocks", 100 * kMiB);
  for (uint32_t i = 0; i < 5; ++i) {
    const auto block = store.load(source, 0, i, 0);
    REQUIRE(block.has_value());
    CHECK(same_bits(*block, noise(i)));
  }
  CHECK_FALSE(store.load(source, 0, 5, 0).has_value());
  CHECK_FALSE(store.load(source, 1, 0, 0).has_value());
  CHECK_FALSE(store.load(BlockStore::source_of(info_of("v2")), 0, 0, 0).has_value());
  CHECK(store.stats().loaded == 5);
}

TEST_CASE("damaged files are removed, and their blocks made again") {
  const TempFolder folder;
  const auto source = BlockStore::source_of(info_of("v1"));
  for (const int damage : {0, 1, 2, 3}) {
    BlockStore store(folder.path(), 100 * kMiB);
    save(store, source, 0, noise(1));
    store.flush();
    REQUIRE(files_in(folder.path()).size() == 1);
    const fs::path file = files_in(folder.path())[0];
    std::string bytes = bytes_of(file);
    if (damage == 0) bytes.resize(bytes.size() / 2);
    if (damage == 1) bytes.clear();
    if (damage == 2) bytes[bytes.size() - 3] = static_cast<char>(bytes[bytes.size() - 3] ^ 4);
    if (damage == 3) bytes[7] = '0';  // another version
    put_bytes(file, bytes);
    CHECK_FALSE(store.load(source, 0, 0, 0).has_value());
    CHECK(store.stats().damaged == 1);
    CHECK(files_in(folder.path()).empty());
  }
}

TEST_CASE("beyond the budget the files go that were used longest ago") {
  const TempFolder folder;
  const auto source = BlockStore::source_of(info_of("v1"));
  BlockStore store(folder.path(), kMiB);
  for (uint32_t i = 0; i < 20; ++i) save(store, source, i, noise(i));
  store.flush();
  CHECK(store.stats().removed == 0);
  test::sleep_s(0.02);  // file times are those of the kernel's clock tick
  CHECK(store.load(source, 0, 3, 0).has_value());
  test::sleep_s(0.02);
  for (uint32_t i = 20; i < 80; ++i) save(store, source, i, noise(i));
  store.flush();
  CHECK(store.stats().removed > 0);
  CHECK(bytes_in(folder.path()) <= kMiB);
  CHECK(bytes_in(folder.path()) > kMiB / 2);
  CHECK(store.load(source, 0, 79, 0).has_value());
  CHECK_FALSE(store.load(source, 0, 0, 0).has_value());
  CHECK(store.load(source, 0, 3, 0).has_value());
}

TEST_CASE("two processes write and read one folder at the same time, and all that is there is whole") {
  const TempFolder folder;
  const auto source = BlockStore::source_of(info_of("v1"));
  std::vector<pid_t> children;
  for (uint32_t child = 0; child < 2; ++child) {
    const pid_t pid = ::fork();
    if (pid == 0) {
      uint32_t wrong = 0;
      {
        BlockStore store(folder.path(), kMiB / 2);  // too small: both remove files while the other reads
        for (uint32_t i = 0; i < 300; ++i) {
          const uint32_t bx = (i * 7 + child * 3) % 60;
          const auto block = store.load(source, 0, bx, 0);
          if (block && !same_bits(*block, noise(bx))) ++wrong;
          if (!block) save(store, source, bx, noise(bx));
        }
        store.flush();
        if (store.stats().damaged > 0 || !store.stats().writing) ++wrong;
      }
      ::_exit(wrong == 0 ? 0 : 1);
    }
    REQUIRE(pid > 0);
    children.push_back(pid);
  }
  for (const pid_t pid : children) {
    int status = -1;
    ::waitpid(pid, &status, 0);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
  }
  BlockStore store(folder.path(), kMiB / 2);
  uint32_t there = 0;
  for (uint32_t i = 0; i < 60; ++i)
    if (const auto block = store.load(source, 0, i, 0)) {
      ++there;
      CHECK(same_bits(*block, noise(i)));
    }
  CHECK(there > 0);
  for (const fs::path& file : files_in(folder.path())) CHECK(file.extension() == ".block");
}

TEST_CASE("a folder that cannot be made turns writing off, and nothing else happens") {
  const TempFolder folder;
  put_bytes(folder.path() / "file", "in the way");
  const auto source = BlockStore::source_of(info_of("v1"));
  BlockStore store(folder.path() / "file" / "blocks", 100 * kMiB);
  for (uint32_t i = 0; i < 3; ++i) save(store, source, i, noise(i));
  store.flush();
  CHECK_FALSE(store.stats().writing);
  CHECK_FALSE(store.load(source, 0, 0, 0).has_value());
}

TEST_CASE("a disk that takes no more bytes turns writing off and leaves no part of a file") {
  const TempFolder folder;
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{5000, 5000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    bool good = true;
    {
      const auto source = BlockStore::source_of(info_of("v1"));
      BlockStore store(folder.path(), 100 * kMiB);
      save(store, source, 0, noise(1, 16));  // fits
      save(store, source, 1, noise(2, 256));
      save(store, source, 2, noise(3, 16));
      store.flush();
      good = good && !store.stats().writing && store.stats().saved == 1;
      good = good && store.load(source, 0, 0, 0).has_value() && !store.load(source, 0, 1, 0).has_value();
    }
    ::_exit(good ? 0 : 1);
  }
  REQUIRE(pid > 0);
  int status = -1;
  ::waitpid(pid, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(files_in(folder.path()).size() == 1);
}

TEST_CASE("a cache finds the dear blocks of an earlier one on disk, with the same bits") {
  const TempFolder folder;
  const auto make = [](const std::string& fingerprint) {
    const auto raster = std::make_shared<PlaneRaster>(16384, 8192);
    raster->info_.fingerprint = fingerprint;
    raster->before = [](uint32_t, uint32_t, uint32_t, uint64_t) {
      test::sleep_s(0.004);
      return true;
    };
    return raster;
  };
  const auto all = [](const BlockCache& cache) {
    std::vector<std::shared_ptr<const BlockCache::Block>> blocks;
    for (const uint32_t k : {6u, 0u, 3u}) blocks.push_back(cache.block(k, 0, 0));
    return blocks;
  };
  const auto cold = make("v1"), warm = make("v1"), changed = make("v2"), without = make("");
  const BlockCache plain(without);
  const auto expected = all(plain);
  {
    const BlockCache cache(cold, {.disk = std::make_shared<BlockStore>(folder.path(), 100 * kMiB)});
    all(cache);
    CHECK(cold->reads == 33);  // one at 0, 32 at 3 for the one at 6
  }
  const auto disk = std::make_shared<BlockStore>(folder.path(), 100 * kMiB);
  const BlockCache cache(warm, {.disk = disk});
  const auto found = all(cache);
  CHECK(warm->reads == 0);
  CHECK(cache.stats().from_disk == 3);
  for (size_t i = 0; i < found.size(); ++i) CHECK(same_bits(found[i]->data, expected[i]->data));
  const BlockCache other(changed, {.disk = disk});
  all(other);
  CHECK(changed->reads == 33);
}

TEST_CASE("neither cheap blocks nor failed ones go to the disk, and a filter sees what the raster delivers") {
  const TempFolder folder;
  const auto raster = std::make_shared<PlaneRaster>(1024, 8);  // so few pixels that the first block is cheap
  raster->info_.fingerprint = "v1";
  raster->before = [](uint32_t, uint32_t bx, uint32_t, uint64_t) {
    if (bx > 0) test::sleep_s(0.004);
    return bx != 1;
  };
  const auto filter = [](RasterBlock& block, uint32_t, uint32_t, uint32_t) {
    for (float& v : block.values) v += 1000.0f;
  };
  for (int round = 0; round < 2; ++round) {
    const auto disk = std::make_shared<BlockStore>(folder.path(), 100 * kMiB);
    const BlockCache cache(raster, {.disk = disk}, filter);
    for (uint32_t i = 0; i < 4; ++i) cache.block(0, i, 0);
    cache.block(4, 1, 0);
    CHECK(cache.block(0, 2, 0)->data.values[0] == 1000.0f + 2.0f * 512 + 1.0f);
    disk->flush();
    CHECK(disk->stats().loaded == (round == 0 ? 0 : 2));
    CHECK(files_in(folder.path()).size() == 2);
  }
}
