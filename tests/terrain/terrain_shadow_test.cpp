#include "terrain/terrain_shadow_map.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace nepho;

namespace {

constexpr size_t kSide = shared::kShadowTexels;

std::vector<float> rough(uint32_t state) {
  std::vector<float> heights(kSide * kSide);
  for (float& h : heights) {
    state = state * 1664525u + 1013904223u;
    h = static_cast<float>(state >> 8) * 1e-4f;
  }
  return heights;
}

}  // namespace

TEST_CASE(
    "a horizon through a disc's centre hides half of it, one a radius below nothing, and half a radius a known "
    "segment") {
  CHECK(shared::disc_share(0.0f) == doctest::Approx(0.5));
  CHECK(shared::disc_share(1.0f) == doctest::Approx(1.0));
  CHECK(shared::disc_share(3.0f) == doctest::Approx(1.0));
  CHECK(shared::disc_share(-1.0f) == doctest::Approx(0.0));
  // The segment beyond half a radius is (pi / 3 - sqrt(3) / 4) of pi.
  CHECK(static_cast<double>(shared::disc_share(-0.5f)) ==
        doctest::Approx(1.0 / 3.0 - std::sqrt(3.0) / (4.0 * 3.14159265)).epsilon(1e-4));
  CHECK(static_cast<double>(shared::disc_share(0.5f) + shared::disc_share(-0.5f)) == doctest::Approx(1.0));
}

TEST_CASE("mips of the shadow map hold the highest ground of a cell and its eight neighbours, finer levels included") {
  const std::vector<float> fine = rough(1), coarse = rough(7);
  std::vector<std::vector<float>> mips;
  const std::vector<float> inside = highest_around(fine, {}, mips);
  CHECK(inside == fine);
  for (int with_finer = 0; with_finer < 2; ++with_finer) {
    std::vector<float> all = with_finer ? coarse : fine;
    if (with_finer) {
      highest_around(coarse, inside, mips);
      for (size_t j = 0; j < kSide; ++j)
        for (size_t i = 0; i < kSide; ++i) {
          float& h = all[(kSide / 4 + j / 2) * kSide + kSide / 4 + i / 2];
          h = std::max(h, fine[j * kSide + i]);
        }
    }
    REQUIRE(mips.size() == shared::kShadowMips);
    CHECK(mips[0] == (with_finer ? coarse : fine));
    for (size_t m = 1; m < mips.size(); ++m) {
      const size_t side = kSide >> m, cell = size_t{1} << m;
      REQUIRE(mips[m].size() == side * side);
      for (size_t y = 0; y < side; y += 3)
        for (size_t x = 0; x < side; x += 5) {
          float most = -1.0f;
          for (size_t j = y > 0 ? (y - 1) * cell : 0; j < std::min((y + 2) * cell, kSide); ++j)
            for (size_t i = x > 0 ? (x - 1) * cell : 0; i < std::min((x + 2) * cell, kSide); ++i)
              most = std::max(most, all[j * kSide + i]);
          REQUIRE(mips[m][y * side + x] == most);
        }
    }
  }
}
