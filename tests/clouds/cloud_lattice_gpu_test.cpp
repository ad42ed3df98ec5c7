// No lattice, no repetition: spectra and autocorrelations of optical depth from above and of slices of density.
#include <algorithm>
#include <cmath>

#include "clouds/cloud_test_tools.h"

namespace nepho::test {
namespace {

/// Near the middle of a steep spectrum the 9 x 9 neighbourhood of an ordinate spans powers of ten, whatever the field:
/// there the raw ratio tells the slope. So an ordinate counts by the smaller of its raw ratio and that of the
/// prewhitened spectrum (highest_true_line()); where slopes are gentle, from 12 cycles a window on, the raw one is
/// asserted too. A lattice-free field of this size gives 1.3 with 225 windows, 1.8 with 81 (statistics_test.cpp).
constexpr double kLeast = 3.0, kGentle = 12.0;
constexpr double kLimit = 3.0;

std::string check_spectrum(const std::string& what, const Spectrum& spectrum, double pixel_m, bool raw_too = true) {
  const LatticeLine line = highest_true_line(spectrum, kLeast), raw = highest_line(spectrum, kLeast),
                    gentle = highest_line(spectrum, kGentle);
  const double wave_m = static_cast<double>(spectrum.size) * pixel_m /
                        std::hypot(static_cast<double>(line.kx), static_cast<double>(line.ky));
  char text[300];
  std::snprintf(
      text, sizeof text, "%s, %zu windows of %zu: %.2f (at %ld, %ld: %.0f m); raw %.2f from 12 cycles, %.2f from 3",
      what.c_str(), spectrum.windows, spectrum.size, line.ratio, line.kx, line.ky, wave_m, gentle.ratio, raw.ratio);
  CAPTURE(what);
  CHECK(spectrum.windows >= 64);
  CHECK(line.ratio <= kLimit);
  if (raw_too) CHECK(gentle.ratio <= kLimit);
  return text;
}

struct Case {
  const char* genus;
  Place place;
};

TEST_CASE(
    "gpu: a nadir image of optical depth 400 km wide has no line in its spectrum above 3 times its neighbourhood, and "
    "no "
    "summit of its autocorrelation beyond 20 km more prominent than 0.2") {
  GpuFixture gpu;
  constexpr double kSide_m = 400e3;
  const size_t pixels = full_size() ? 1024 : 512;
  const Place places[] = {{35.5, 138.7}, {-8.0, -60.0}, {61.0, 20.0}};
  std::vector<Case> cases = {{"cumulus", places[0]}};
  if (full_size()) {
    cases.clear();
    for (const char* genus : {"cumulus", "stratocumulus", "altocumulus", "cirrus"})
      for (const Place& place : places) cases.push_back({genus, place});
  }
  for (const Case& c : cases) {
    const Clouds clouds(gpu.device, genus_sky(c.genus, 0.5));
    CloudProbe probe(gpu.device, clouds);
    const Grid image = depth_grid(probe, c.place, kSide_m, pixels, kSide_m / static_cast<double>(pixels));
    const std::string what = std::string(c.genus) + " at " + std::to_string(static_cast<int>(c.place.lat_deg));
    const double pixel_m = kSide_m / static_cast<double>(pixels);
    const bool gentle = std::string(c.genus) != "cirrus";  // an eightfold stretched spectrum is a steep ridge
    MESSAGE(check_spectrum(what, hann_spectrum(image, pixels / 8, pixels / 16), pixel_m, gentle));
    // Longer waves: fewer windows, though more than 64.
    if (full_size()) MESSAGE(check_spectrum(what, hann_spectrum(image, pixels / 4, pixels * 3 / 32), pixel_m, gentle));
    const Summit summit = most_prominent(autocorrelation(image), 20e3 / pixel_m);
    MESSAGE(what, ": autocorrelation's most prominent summit beyond 20 km ", summit.prominence, " (height ",
            summit.height, ") at ", summit.distance * pixel_m * 1e-3, " km");
    CHECK(summit.prominence <= 0.2);
  }
}

/// Density of all layers over a plane of pixels; `at(x, y)` gives places.
template <typename At>
Grid density_grid(CloudProbe& probe, size_t width, size_t height, double footprint_m, At&& at) {
  Grid grid(width, height);
  std::vector<CloudProbe::Case> cases;
  for (size_t y0 = 0; y0 < height; y0 += 64) {
    cases.clear();
    const size_t rows = std::min<size_t>(64, height - y0);
    for (size_t y = 0; y < rows; ++y)
      for (size_t x = 0; x < width; ++x)
        cases.push_back({.point = at(static_cast<double>(x), static_cast<double>(y0 + y)),
                         .camera = {},
                         .time_s = kQuietTime_s,
                         .footprint_m = footprint_m});
    const auto found = probe.density(cases);
    for (size_t i = 0; i < found.size(); ++i)
      for (int l = 0; l < 4; ++l) grid.values[y0 * width + i] += static_cast<double>(found[i].density[l]);
  }
  return grid;
}

TEST_CASE("gpu: horizontal and vertical slices of density at 20 m have no line in their spectra") {
  GpuFixture gpu;
  constexpr double kPixel_m = 20.0;
  const size_t pixels = full_size() ? 2048 : 512;
  for (const char* genus : {"cumulus", "stratocumulus"}) {
    if (!full_size() && std::string(genus) != "cumulus") continue;
    const CloudParams params = genus_sky(genus, 0.6);
    const CloudLayer& layer = params.layers[0];
    const Clouds clouds(gpu.device, params);
    CloudProbe probe(gpu.device, clouds);
    const Patch patch(35.5, 138.7);
    const Grid flat = density_grid(probe, pixels, pixels, kPixel_m, [&](double x, double y) {
      return patch.at(x * kPixel_m, y * kPixel_m, layer.base_m + 0.3 * layer.thickness_m);
    });
    MESSAGE(check_spectrum(std::string(genus) + ", horizontal slice", hann_spectrum(flat, pixels / 16, pixels / 32),
                           kPixel_m, true));
    if (full_size())
      MESSAGE(check_spectrum(std::string(genus) + ", horizontal slice",
                             hann_spectrum(flat, pixels / 4, pixels * 3 / 32), kPixel_m));
    // Layers are thinner than 41 km: the vertical slice lies in strips as high as the layer, each 7 km north of the one
    // before, to as many pixels in all. What changes with height on average is no lattice: it is taken out of each row.
    const size_t rows = 32;  // 640 m
    Spectrum sum{rows, 0, std::vector<double>(rows * rows, 0.0)};
    std::vector<Grid> strips;
    for (size_t strip = 0; strip < pixels / rows; ++strip)
      strips.push_back(density_grid(probe, pixels, rows, kPixel_m, [&](double x, double y) {
        return patch.at(x * kPixel_m, 7e3 * static_cast<double>(strip),
                        layer.base_m + 0.03 * layer.thickness_m +
                            y * std::min(kPixel_m, 0.9 * layer.thickness_m / static_cast<double>(rows)));
      }));
    for (size_t y = 0; y < rows; ++y) {
      double row_mean = 0.0;
      for (const Grid& g : strips)
        for (size_t x = 0; x < pixels; ++x) row_mean += g.at(x, y) / static_cast<double>(pixels * strips.size());
      for (Grid& g : strips)
        for (size_t x = 0; x < pixels; ++x) g.at(x, y) -= row_mean;
    }
    for (const Grid& g : strips) sum = hann_spectrum(g, rows, rows / 2, &sum);
    MESSAGE(check_spectrum(std::string(genus) + ", vertical slices", sum, kPixel_m, false));
  }
}

}  // namespace
}  // namespace nepho::test
