// Coverage is a quantity: the share of sky with vertical optical depth above a layer's cover_optical_depth.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clouds/cloud_test_tools.h"

namespace nepho::test {
namespace {

/// Sixteen squares of 300 km, apart from each other: both hemispheres, poles, cube edges, the antimeridian.
constexpr Place kSquares[16] = {{35.5, 138.7}, {-12.0, 30.0},   {62.0, -80.0},  {0.5, 179.9},
                                {88.5, 10.0},  {-88.5, 100.0},  {45.0, 45.0},   {-35.0, 135.0},
                                {20.0, -45.0}, {-50.0, -135.0}, {5.0, -100.0},  {70.0, 90.0},
                                {-65.0, 0.0},  {28.0, 75.0},    {-25.0, -60.0}, {10.0, 0.0}};

struct Cover {
  double share = 0.0;      ///< of columns whose depth reaches the layer's own threshold
  double thinnest = 1e30;  ///< least depth
  double deviation = 0.0;  ///< between the squares
};

Cover cover(GpuFixture& gpu, const CloudParams& params, size_t side) {
  const Clouds clouds(gpu.device, params);
  CloudProbe probe(gpu.device, clouds);
  const double threshold = params.layers[0].cover_optical_depth;
  Cover out;
  double square_sum = 0.0;
  for (const Place& place : kSquares) {
    double covered = 0.0;
    const auto columns = probe.column(square_cases(place, 300e3, side, 10.0));
    for (const CloudProbe::Column& c : columns) {
      covered += total_depth(c) > threshold;
      out.thinnest = std::min(out.thinnest, total_depth(c));
    }
    covered /= static_cast<double>(columns.size());
    out.share += covered / 16.0;
    square_sum += covered * covered / 16.0;
  }
  out.deviation = std::sqrt(std::max(square_sum - out.share * out.share, 0.0));
  return out;
}

TEST_CASE(
    "gpu: the mean cover of 16 squares of 300 km is the asked coverage within 0.05, for every genus; 1 has no holes") {
  GpuFixture gpu;
  const size_t side = full_size() ? 40 : 14;
  const double step = full_size() ? 0.1 : 0.35;
  for (const std::string& genus : cloud_genus_names()) {
    CAPTURE(genus);
    std::string line = genus + ":";
    double worst = 0.0;
    for (double c = step; c < 0.999; c += step) {
      const Cover found = cover(gpu, genus_sky(genus, c), side);
      line += " " + std::to_string(found.share).substr(0, 5);
      worst = std::max(worst, std::abs(found.share - c));
      CAPTURE(c);
      CHECK(std::abs(found.share - c) < 0.05);
    }
    const Cover whole = cover(gpu, genus_sky(genus, 1.0), full_size() ? 80 : 40);
    MESSAGE(line, "; worst ", worst, "; at 1: cover ", whole.share, ", thinnest column ", whole.thinnest);
    CHECK(whole.share == 1.0);
  }
}

TEST_CASE("gpu: coverage 0, and layers without thickness, density or scale, cost nothing and are exactly clear") {
  GpuFixture gpu;
  CloudParams none = genus_sky("cumulus", 0.5);
  none.layers = {genus_layer("stratus"), genus_layer("cumulus"), genus_layer("cirrus"), genus_layer("altocumulus")};
  none.layers[0].thickness_m = 0.0;
  none.layers[1].density_scale = 0.0;
  none.layers[2].coverage_scale = 0.0;
  CHECK(drawing_layers(none) == std::vector<uint32_t>{3});
  const Clouds one(gpu.device, none);
  CHECK(one.specialisation(1)[1] == 1);  // the march's loop over layers has one turn
  CHECK(one.constants().layer_count == 1);
  CHECK(one.constants().layers[0].slot == 3);
  CHECK(one.constants().hull_low_m == doctest::Approx(none.layers[3].base_m));
  CHECK(one.constants().hull_high_m == doctest::Approx(none.layers[3].base_m + none.layers[3].thickness_m));
  CloudProbe probe(gpu.device, one);
  double most = 0.0;
  for (const CloudProbe::Column& c : probe.column(square_cases(kSquares[0], 300e3, 12, 10.0))) {
    CHECK(c.optical_depth.x == 0.0f);
    CHECK(c.optical_depth.y == 0.0f);
    CHECK(c.optical_depth.z == 0.0f);
    most = std::max(most, total_depth(c));
  }
  CHECK(most > 1.0);
  for (const std::string& genus : cloud_genus_names()) {
    CHECK(draws_nothing(genus_sky(genus, 0.0)));
    const Clouds clear(gpu.device, genus_sky(genus, 0.0));
    for (const CloudProbe::Column& c : CloudProbe(gpu.device, clear).column(square_cases(kSquares[1], 300e3, 4, 10.0)))
      CHECK(c.optical_depth == glm::vec4(0.0f));
  }
}

TEST_CASE(
    "gpu: a layer's coverage is coverage_scale times the sky's, and the weather's value to the weather_exponent") {
  GpuFixture gpu;
  CloudParams params = genus_sky("cumulus", 0.4);
  for (const double scale : {0.5, 1.5, 2.0}) {
    params.layers[0].coverage_scale = scale;
    CHECK(std::abs(cover(gpu, params, 14).share - 0.4 * scale) < 0.05);
  }
  // Of a map: a procedural one without contrast is its mean everywhere.
  CloudParams map = genus_sky("cumulus", 0.4);
  map.coverage = std::nullopt;
  map.weather.contrast = 0.0;
  map.weather.mean_coverage_r = 0.6;
  std::string line;
  for (const double exponent : {1.0, 2.0, 0.5}) {
    map.layers[0].weather_exponent = exponent;
    const double found = cover(gpu, map, 14).share;
    line += " " + std::to_string(found);
    CHECK(std::abs(found - std::pow(0.6, exponent)) < 0.06);
  }
  MESSAGE("0.6 to the powers 1, 2, 0.5:", line);
}

TEST_CASE("gpu: a layer too thin for its cover_optical_depth warns and says what helps") {
  GpuFixture gpu;
  CloudParams thin = genus_sky("cumulus", 0.5);
  thin.layers[0].thickness_m = 20.0;
  const auto said = [&](const CloudParams& params) {
    std::FILE* file = std::tmpfile();
    const int before = dup(STDERR_FILENO);
    dup2(fileno(file), STDERR_FILENO);
    const Clouds clouds(gpu.device, params);
    dup2(before, STDERR_FILENO);
    close(before);
    std::rewind(file);
    std::string text(4096, 0);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    std::fclose(file);
    return text;
  };
  const std::string warning = said(thin);
  CHECK(warning.find("clouds.layers[0]") != std::string::npos);
  CHECK(warning.find("raise density_scale or thickness_m") != std::string::npos);
  CHECK(said(genus_sky("cumulus", 0.5)) == "");
}

}  // namespace
}  // namespace nepho::test
