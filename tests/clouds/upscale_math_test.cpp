// Patterns and rules of the clouds' temporal upscaling.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>

#include "clouds/upscale_shared.h"

using namespace nepho::shared;

TEST_CASE("one pixel in 16 is taken in the order of Bayer's 4 x 4 matrix") {
  const int bayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) CHECK(bayer4_place(static_cast<uint>(bayer[y][x])) == ivec2(x, y));
  CHECK(bayer4_place(16) == bayer4_place(0));
}

TEST_CASE("one pixel in 4 is taken in the order in which the Halton sequence first enters the quarters") {
  std::array<ivec2, 4> order;
  size_t found = 0;
  for (uint i = 1; found < 4; ++i) {
    const ivec2 quarter(upscale_halton(i, 2) >= 0.5f, upscale_halton(i, 3) >= 0.5f);
    if (std::find(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(found), quarter) ==
        order.begin() + static_cast<std::ptrdiff_t>(found))
      order[found++] = quarter;
  }
  for (uint i = 0; i < 4; ++i) CHECK(halton4_place(i) == order[i]);
}

TEST_CASE("every pattern takes each pixel once in a cycle, and knows the pixel of its own that is nearest") {
  for (const uint upscale : {2u, 4u, 16u}) {
    std::array<int, 64> taken{};
    for (uint number = 0; number < upscale; ++number) {
      UpscaleConstants u{};
      u.upscale = upscale;
      const int side = upscale == 16 ? 4 : 2;
      u.base = upscale == 16 ? bayer4_place(number) : upscale == 4 ? halton4_place(number) : ivec2(number & 1u, 0);
      u.step_x = upscale == 2 ? ivec2(1, 1) : ivec2(side, 0);
      u.step_y = upscale == 2 ? ivec2(1, -1) : ivec2(0, side);
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          taken[static_cast<size_t>(8 * y + x)] += in_pattern(u, ivec2(x, y));
          const ivec2 nearest = nearest_in_pattern(u, ivec2(x, y));
          CHECK(in_pattern(u, nearest));
          const ivec2 off = nearest - ivec2(x, y);
          CHECK(std::max(std::abs(off.x), std::abs(off.y)) <= side / 2);
          if (in_pattern(u, ivec2(x, y))) CHECK(off == ivec2(0));
        }
    }
    CHECK(std::all_of(taken.begin(), taken.end(), [](int n) { return n == 1; }));
  }
}

TEST_CASE("the visits of a pixel spread over it: the mean of their offsets is its centre, to a hundredth") {
  vec2 sum(0.0f);
  for (uint visit = 0; visit < 1024; ++visit) sum += upscale_jitter_px(16 * visit + 5, 16);
  CHECK(std::abs(sum.x) / 1024.0f < 0.01f);
  CHECK(std::abs(sum.y) / 1024.0f < 0.01f);
  CHECK(upscale_jitter_px(15, 16) == vec2(0.0f));
}

TEST_CASE("a clip moves a colour towards the mean on a straight line, onto the box") {
  const vec4 mean(1.0f, 0.2f, -0.1f, 0.5f), half_side(0.5f, 0.1f, 0.1f, 0.2f);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-3.0f, 3.0f);
  for (int i = 0; i < 200; ++i) {
    const vec4 value(any(random), any(random), any(random), any(random));
    const vec4 clipped = clip_to_box(value, mean, half_side);
    if (outside_box(value, mean, half_side) <= 1.0f) {
      CHECK(clipped == value);
      continue;
    }
    CHECK(outside_box(clipped, mean, half_side) == doctest::Approx(1.0f).epsilon(1e-4));
    const vec4 a = value - mean, b = clipped - mean;
    CHECK(dot(a, b) == doctest::Approx(length(a) * length(b)).epsilon(1e-4));
  }
}

TEST_CASE("YCoCg there and back is the colour; grey has no chroma") {
  const vec3 c(3.0f, 0.25f, 7.0f);
  const vec3 back = rgb_from_ycocg(ycocg_from_rgb(c));
  for (int i = 0; i < 3; ++i) CHECK(back[i] == doctest::Approx(c[i]));
  CHECK(ycocg_from_rgb(vec3(2.0f)) == vec3(2.0f, 0.0f, 0.0f));
}

TEST_CASE("Catmull-Rom's weights sum to 1, pass through the texels and keep straight lines") {
  CHECK(catmull_rom(0.0f) == vec4(0.0f, 1.0f, 0.0f, 0.0f));
  for (const float u : {0.1f, 0.5f, 0.83f}) {
    const vec4 w = catmull_rom(u);
    CHECK(w.x + w.y + w.z + w.w == doctest::Approx(1.0f));
    CHECK(-w.x + w.z + 2.0f * w.w == doctest::Approx(u));
  }
}

TEST_CASE("a point seen by a camera is found again in the picture of the one before, where that one saw it") {
  UpscaleConstants u{};
  u.forward = vec3(1.0f, 0.0f, 0.0f);
  const vec3 right(0.0f, -0.8f, 0.0f), up(0.0f, 0.0f, 0.45f);
  u.right = right / dot(right, right);
  u.up = up / dot(up, up);
  vec2 at;
  REQUIRE(previous_pixel(u, uvec2(160, 90), 700.0f * (u.forward + 0.5f * right - 0.25f * up), at));
  CHECK(at.x == doctest::Approx(120.0f));
  CHECK(at.y == doctest::Approx(56.25f));
  CHECK(!previous_pixel(u, uvec2(160, 90), vec3(-1.0f, 0.0f, 0.0f), at));
}

TEST_CASE("weights of new samples make a plain mean of equals, and a lone spark counts for less") {
  CHECK(new_weight(0.0f, 5.0f, 1.0f) == 1.0f);
  CHECK(new_weight(3.0f, 1.0f, 1.0f) == doctest::Approx(0.25f));
  CHECK(new_weight(3.0f, 100.0f, 1.0f) < 0.01f);
  CHECK(samples_left(16.0f, 0.9f) == 16.0f);
  CHECK(samples_left(16.0f, 2.0f) == 4.0f);
  CHECK(most_samples(0.0f) == kMostSamples);
  CHECK(most_samples(5.0f) == kMovingSamples);
}
