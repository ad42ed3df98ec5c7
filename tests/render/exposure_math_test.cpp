#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "common/tonemap.h"

using namespace nepho::shared;

namespace {

constexpr std::array kCurves = {kToneLinear, kToneReinhard, kToneAces, kToneAgx};
using Rgb = std::array<double, 3>;
using Rows = std::array<Rgb, 3>;

Rgb operator*(const Rows& m, const Rgb& v) {
  Rgb out{};
  for (size_t r = 0; r < 3; ++r) out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
  return out;
}

template <typename F>
Rgb each(const Rgb& v, const F& f) {
  return {f(v[0]), f(v[1]), f(v[2])};
}

/// Colours over 24 stops and all hues, within Rec. 709.
std::vector<vec3> many_colours() {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> share(0.0f, 1.0f), stops(-16.0f, 8.0f);
  std::vector<vec3> out;
  for (int i = 0; i < 20000; ++i)
    out.push_back(vec3(share(random), share(random), share(random)) * std::exp2(stops(random)));
  for (float v = 1e-6f; v < 300.0f; v *= 1.02f) out.push_back(vec3(v));
  return out;
}

void check_close(const vec3& found, const Rgb& expected, double tolerance) {
  for (int c = 0; c < 3; ++c)
    CHECK(std::abs(static_cast<double>(found[c]) - expected[static_cast<size_t>(c)]) < tolerance);
}

const std::array<Rgb, 6> kExamples = {Rgb{0.18, 0.18, 0.18}, Rgb{0.9, 0.5, 0.2}, Rgb{0.02, 0.05, 0.2},
                                      Rgb{3.0, 2.0, 1.0},    Rgb{0.2, 0.7, 0.4}, Rgb{12, 9, 5}};

vec3 narrow(const Rgb& v) { return vec3(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])); }

}  // namespace

TEST_CASE("tone curve aces is Hill's fit as published, and shows middle grey at a tenth") {
  // BakingLab, ACES.hlsl; rows as printed there.
  const Rows in = {Rgb{0.59719, 0.35458, 0.04823}, Rgb{0.07600, 0.90834, 0.01566}, Rgb{0.02840, 0.13383, 0.83777}};
  const Rows out = {Rgb{1.60475, -0.53108, -0.07367}, Rgb{-0.10208, 1.10813, -0.00605},
                    Rgb{-0.00327, -0.07276, 1.07602}};
  const auto fit = [](double v) {
    return (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
  };
  for (const Rgb& v : kExamples) check_close(tone_aces(narrow(v)), out * each(in * v, fit), 1e-5);
  // The ACES output transform for cinema shows 0.18 at 4.8 of 48 cd/m2.
  CHECK(tone_map(vec3(0.18f), kToneAces).g == doctest::Approx(0.10).epsilon(0.06));
}

TEST_CASE("tone curve agx is the minimal fit as published, with our look, and middle grey at AgX's pivot") {
  // Wrensch 2023, 'Minimal AgX Implementation'; columns as printed there, here as rows.
  const Rows in = {Rgb{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                   Rgb{0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                   Rgb{0.0423756549057051, 0.0784336, 0.879142973793104}};
  const Rows out = {Rgb{1.19687900512017, -0.0980208811401368, -0.0990297440797205},
                    Rgb{-0.0528968517574562, 1.15190312990417, -0.0989611768448433},
                    Rgb{-0.0529716355144438, -0.0980434501171241, 1.15107367264116}};
  for (const Rgb& v : kExamples) {
    Rgb x = each(in * v, [](double a) {
      const double e = std::clamp(std::log2(a), -12.47393, 4.026069);
      const double t = (e + 12.47393) / (4.026069 + 12.47393);
      return 15.5 * std::pow(t, 6) - 40.14 * std::pow(t, 5) + 31.96 * std::pow(t, 4) - 6.868 * std::pow(t, 3) +
             0.4298 * t * t + 0.1191 * t - 0.00232;
    });
    x = each(x, [](double a) { return std::pow(std::max(a, 0.0), 1.15); });
    const double grey = 0.2126 * x[0] + 0.7152 * x[1] + 0.0722 * x[2];
    x = each(x, [grey](double a) { return grey + 1.2 * (a - grey); });
    x = each(out * x, [](double a) { return std::pow(std::max(a, 0.0), 2.2); });
    check_close(tone_agx(narrow(v)), x, 2e-5);
  }
  // Sobotka's curve has its pivot at 0.18^(1/2.4); the sixth-degree fit is good to half a percent.
  CHECK(agx_contrast(agx_log(vec3(0.18f))).g == doctest::Approx(std::pow(0.18, 1.0 / 2.4)).epsilon(0.01));
}

TEST_CASE("tone curve reinhard is equation 4 with white at 4; linear is linear and clips at 1") {
  for (const double l : {0.01, 0.18, 1.0, 3.0}) {
    const float v = static_cast<float>(l);
    CHECK(tone_map(vec3(v), kToneReinhard).r == doctest::Approx(l * (1.0 + l / 16.0) / (1.0 + l)).epsilon(1e-5));
    CHECK(tone_map(vec3(v), kToneLinear).r == doctest::Approx(std::min(l, 1.0)).epsilon(1e-6));
  }
  CHECK(tone_map(vec3(4.0f), kToneReinhard).b == doctest::Approx(1.0).epsilon(1e-5));
  // Hue: a colour keeps its ratios below white.
  const vec3 mapped = tone_map(vec3(0.4f, 0.3f, 0.2f), kToneReinhard);
  CHECK(mapped.r / mapped.b == doctest::Approx(2.0).epsilon(1e-5));
}

TEST_CASE("tone curves: from black to white without a step back") {
  for (const uint curve : kCurves) {
    CAPTURE(curve);
    CHECK(luminance(display_from_exposed(vec3(0.0f), curve)) == 0.0f);
    float last = 0.0f;
    for (float v = 1e-5f; v < 1e4f; v *= 1.01f) {
      const float shown = tone_map(vec3(v), curve).g;
      CHECK(shown >= last - 1e-6f);
      last = shown;
    }
    CHECK(last > 0.99f);
    CHECK(last <= 1.0f);
  }
}

TEST_CASE("tone curves: a sunset's orange goes to white with more light, without a hard edge") {
  for (const uint curve : {kToneReinhard, kToneAces, kToneAgx}) {
    CAPTURE(curve);
    const auto shown = [&](float stops) {
      return display_from_exposed(vec3(1.0f, 0.3f, 0.04f) * std::exp2(stops), curve);
    };
    float last_spread = 1.0f;
    for (float stops = 0.0f; stops < 14.0f; stops += 0.0625f) {
      const vec3 a = shown(stops), b = shown(stops + 0.0625f);
      // A sixteenth of a stop: at most 10 of 255 steps in any channel.
      for (int c = 0; c < 3; ++c) CHECK(std::abs(b[c] - a[c]) < 10.0f / 255.0f);
      CHECK(luminance(b) >= luminance(a) - 1e-3f);
      if (stops > 3.0f) {
        CHECK(b.r - b.b <= last_spread + 1e-3f);
        last_spread = b.r - b.b;
      }
    }
    const vec3 white = shown(14.0f);
    CHECK(std::min(white.r, std::min(white.g, white.b)) > 0.97f);
  }
}

TEST_CASE("gamut: spectral colours lose their negative parts and keep luminance and hue") {
  // Linear Rec. 709 of monochromatic light (CIE 1931 colour matching functions): 450, 490, 520, 600 and 680 nm.
  const Rows rec709_from_xyz = {Rgb{3.2404542, -1.5371385, -0.4985314}, Rgb{-0.9692660, 1.8760108, 0.0415560},
                                Rgb{0.0556434, -0.2040259, 1.0572252}};
  for (const Rgb& xyz : {Rgb{0.3362, 0.0380, 1.77211}, Rgb{0.03201, 0.20802, 0.46518}, Rgb{0.06327, 0.71, 0.07825},
                         Rgb{1.0622, 0.631, 0.0008}, Rgb{0.04677, 0.017, 0.0}}) {
    const vec3 spectral = narrow(rec709_from_xyz * xyz);
    REQUIRE(std::min(spectral.r, std::min(spectral.g, spectral.b)) < 0.0f);
    const vec3 kept = compress_gamut(spectral);
    CHECK(std::min(kept.r, std::min(kept.g, kept.b)) >= 0.0f);
    CHECK(luminance(kept) == doctest::Approx(luminance(spectral)).epsilon(1e-4));
    // On the line to grey: the same direction from it.
    const vec3 a = glm::normalize(spectral - luminance(spectral)), b = glm::normalize(kept - luminance(kept));
    CHECK(glm::dot(a, b) > 1.0f - 1e-5f);
  }
}

TEST_CASE("gamut: colours within nine tenths of the way to the edge stay, the rest is continuous, order is kept") {
  for (const vec3& v : {vec3(0.18f), vec3(0.1f, 0.2f, 0.9f), vec3(0.9f, 0.6f, 0.3f), vec3(0.0f)})
    for (int c = 0; c < 3; ++c) CHECK(compress_gamut(v)[c] == doctest::Approx(v[c]).epsilon(1e-6));
  // From grey through the edge of the gamut (d = 1) to far outside, at equal luminance.
  float last = 0.0f;
  for (float d = 0.001f; d < 30.0f; d += 0.001f) {
    vec3 away(1.0f, 0.0f, -1.0f);
    away = (away - luminance(away)) / (luminance(away) + 1.0f);
    const vec3 kept = compress_gamut(vec3(1.0f) + d * away);
    const float found = 1.0f - kept.b;
    CHECK(found >= last - 1e-6f);
    CHECK(found - last < 0.00102f);  // never steeper than the identity
    CHECK(found < 1.0f);
    last = found;
  }
  CHECK(compress_gamut(vec3(-0.2f, -0.1f, 0.1f)) == vec3(0.0f));  // no luminance: black
}

TEST_CASE("display: the cheap polynomials are within a tenth of an 8-bit step of the exact curves") {
  for (const uint curve : kCurves) {
    CAPTURE(curve);
    float worst = 0.0f;
    for (const vec3& v : many_colours()) {
      const vec3 exact = tone_map(v, curve), fast = display_from_exposed(v, curve);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(fast[c] - srgb_from_linear(exact[c])));
    }
    CHECK(255.0f * worst < (curve == kToneAgx ? 0.12f : 0.1f));
  }
  CHECK(srgb_from_linear_fast(vec3(0.0f)).r == 0.0f);
  CHECK(srgb_from_linear_fast(vec3(1.0f)).r == doctest::Approx(1.0).epsilon(1e-6));
}

TEST_CASE("dither: a gradient of 0.2 steps in 100 pixels does not band") {
  const uint width = 2048, height = 256;
  std::vector<int> picture(width * height);
  const auto value = [](uint x, uint y) { return 57.1 + 0.002 * x + 0.0007 * y; };
  for (const uint offset : {0u, 0x55555555u, 12345u * 0x9e3779b9u}) {
    for (uint y = 0; y < height; ++y)
      for (uint x = 0; x < width; ++x)
        picture[y * width + x] =
            static_cast<int>(quantise(static_cast<float>(value(x, y) / 255.0), dither_pattern({x, y}, offset)));
    // Blocks of 16 x 16: white noise would err by 0.1 somewhere among 2048 of them.
    double worst = 0.0, squares = 0.0;
    for (uint by = 0; by < height; by += 16)
      for (uint bx = 0; bx < width; bx += 16) {
        double error = 0.0;
        for (uint y = by; y < by + 16; ++y)
          for (uint x = bx; x < bx + 16; ++x) {
            const double e = picture[y * width + x] - value(x, y);
            error += e;
            squares += e * e;
          }
        worst = std::max(worst, std::abs(error / 256.0));
      }
    CHECK(worst < 0.05);
    // Triangular noise and rounding: variance 1/6 + 1/12, whatever the value.
    CHECK(squares / (width * height) == doctest::Approx(0.25).epsilon(0.02));
    // At a whole value one pixel in four differs: runs are short along rows and columns.
    uint longest = 0;
    for (uint y = 0; y < height; ++y)
      for (uint x = 1, run = 1; x < width; ++x) {
        run = picture[y * width + x] == picture[y * width + x - 1] ? run + 1 : 1;
        longest = std::max(longest, run);
      }
    for (uint x = 0; x < width; ++x)
      for (uint y = 1, run = 1; y < height; ++y) {
        run = picture[y * width + x] == picture[(y - 1) * width + x] ? run + 1 : 1;
        longest = std::max(longest, run);
      }
    CHECK(longest <= 12);
  }
}

TEST_CASE("dither: black and white stay, the values beside them have no bias") {
  const auto mean = [](double value) {
    double sum = 0.0;
    for (uint y = 0; y < 128; ++y)
      for (uint x = 0; x < 128; ++x) {
        const float q = quantise(static_cast<float>(value / 255.0), dither_pattern({x, y}, 77u));
        CHECK(q >= 0.0f);
        CHECK(q <= 255.0f);
        sum += static_cast<double>(q);
      }
    return sum / (128.0 * 128.0);
  };
  CHECK(mean(0.0) == 0.0);
  CHECK(mean(255.0) == 255.0);
  for (const double v : {0.1, 0.3, 0.49, 0.51, 0.8, 254.2, 254.7})
    CHECK(mean(v) == doctest::Approx(v).epsilon(0.01 / std::max(v, 1.0)));
}

TEST_CASE("night: exposures of photographic practice, and pictures that fall with the light but never turn round") {
  // Luminance that the meter makes middle grey -> EV100 that is set.
  const auto ev = [](float l) { return ev100_that_shows(l, 0.18f) + night_darkening_ev(l); };
  // Tables of exposure values: a landscape under the full moon -3 to -2 (ANSI PH2.7-1986), starlight -6 (Parker). Grey
  // ground (0.18) under 0.2 lx of moonlight and under 1e-3 lx of a moonless sky.
  CHECK(ev(0.18f * 0.2f / kPi) == doctest::Approx(-2.0).epsilon(0.3));
  CHECK(ev(0.18f * 1.0e-3f / kPi) > -8.0f);
  CHECK(ev(2.0e-4f) == doctest::Approx(-5.8).epsilon(0.1));  // the moonless sky itself
  CHECK(night_darkening_ev(0.01f) == doctest::Approx(2.25));
  for (const float full_moon : {0.003f, 0.005f, 0.01f}) {
    CHECK(night_darkening_ev(full_moon) > 2.0f);
    CHECK(night_darkening_ev(full_moon) < 3.2f);
  }
  for (float l = 7.0f; l < 1e5f; l *= 2.0f) CHECK(night_darkening_ev(l) < 0.05f);  // by day nothing changes
  // A brighter scene is always a brighter picture and a smaller exposure.
  for (float l = 1e-7f; l < 1e5f; l *= 1.1f) {
    CHECK(ev(1.1f * l) > ev(l));
    CHECK(night_darkening_ev(1.1f * l) < night_darkening_ev(l));
  }
}
