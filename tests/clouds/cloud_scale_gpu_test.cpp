// One field: footprints from 10 m to 8 km, and cameras from 400 km to 4,000 km, see the same clouds.
#include <algorithm>
#include <cmath>

#include "clouds/cloud_test_tools.h"

namespace nepho::test {
namespace {

/// Means of the finest field over boxes, from points at random in every cell of a grid over the box: twice, with other
/// points, so that the error of the mean is known. The correlation of a noisy mean with anything is smaller by the
/// square root of its reliability, the correlation of the two halves stepped up to both (Spearman and Brown): corrected
/// for that.
struct Comparison {
  double correlation = 0.0;  ///< corrected
  double as_found = 0.0;     ///< of the sampled means as they are
  double ratio = 0.0;        ///< mean of the coarser / mean of the finest
};

Comparison compare(CloudProbe& probe, const std::vector<Place>& squares, double footprint_m, size_t boxes,
                   size_t grid) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<double> first, second, both, coarse;
  for (const Place& place : squares) {
    const Patch patch(place.lat_deg, place.lon_deg);
    std::vector<CloudProbe::Case> points, centres;
    for (size_t b = 0; b < boxes; ++b) {
      const double east = 300e3 * (uniform(random) - 0.5), north = 300e3 * (uniform(random) - 0.5);
      centres.push_back(
          {.point = patch.at(east, north), .camera = {}, .time_s = kQuietTime_s, .footprint_m = footprint_m});
      for (int half = 0; half < 2; ++half)
        for (size_t i = 0; i < grid * grid; ++i) {
          const double x = (static_cast<double>(i % grid) + uniform(random)) / static_cast<double>(grid) - 0.5;
          const double y = (static_cast<double>(i / grid) + uniform(random)) / static_cast<double>(grid) - 0.5;
          points.push_back({.point = patch.at(east + x * footprint_m, north + y * footprint_m),
                            .camera = {},
                            .time_s = kQuietTime_s,
                            .footprint_m = 10.0});
        }
    }
    const auto fine = probe.column(points), wide = probe.column(centres);
    for (size_t b = 0; b < boxes; ++b) {
      double half_mean[2] = {0.0, 0.0};
      for (size_t i = 0; i < 2 * grid * grid; ++i)
        half_mean[i / (grid * grid)] += total_depth(fine[b * 2 * grid * grid + i]) / static_cast<double>(grid * grid);
      first.push_back(half_mean[0]);
      second.push_back(half_mean[1]);
      both.push_back(0.5 * (half_mean[0] + half_mean[1]));
      coarse.push_back(total_depth(wide[b]));
    }
  }
  const double halves = correlation(first, second), reliability = 2.0 * halves / (1.0 + halves);
  const double found = correlation(both, coarse);
  return {found / std::sqrt(reliability), found, mean(coarse) / mean(both)};
}

TEST_CASE(
    "gpu: columns at 100 m, 800 m and 8 km footprints are the means of columns at 10 m: correlation 0.97, mean within "
    "5 %") {
  GpuFixture gpu;
  const std::vector<Place> squares = {{35.5, 138.7}, {-12.0, 30.0}, {62.0, -80.0}, {0.5, 179.9}};
  for (const std::string& genus : cloud_genus_names()) {
    if (!full_size() && genus != "cumulus" && genus != "cirrus" && genus != "stratocumulus") continue;
    const Clouds clouds(gpu.device, genus_sky(genus, 0.5));
    CloudProbe probe(gpu.device, clouds);
    std::string line = genus + ", correlation (as sampled) and ratio of means:";
    for (const double footprint : {100.0, 800.0, 8000.0}) {
      const size_t boxes = full_size() ? 300 : 50;
      const Comparison c = compare(probe, squares, footprint, boxes,
                                   full_size()       ? (footprint > 1e3 ? 16 : 8)
                                   : footprint > 1e3 ? 8
                                                     : 5);
      char text[100];
      std::snprintf(text, sizeof text, " %.0f m %.3f (%.3f) %.3f", footprint, c.correlation, c.as_found, c.ratio);
      line += text;
      CAPTURE(genus);
      CAPTURE(footprint);
      CHECK(c.correlation >= 0.97);
      CHECK(std::abs(c.ratio - 1.0) < 0.05);
    }
    MESSAGE(line);
  }
}

}  // namespace
}  // namespace nepho::test
