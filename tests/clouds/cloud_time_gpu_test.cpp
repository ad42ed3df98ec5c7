// Time: the same time is the same sky; winds carry fields along; cells form and dissolve; windows of patterns join
// without a jump.
#include <algorithm>
#include <cmath>

#include "clouds/cloud_test_tools.h"

namespace nepho::test {
namespace {

Grid opacity(Grid depths) {
  for (double& v : depths.values) v = 1.0 - std::exp(-v);
  return depths;
}

std::vector<double> opacities(CloudProbe& probe, const std::vector<CloudProbe::Case>& cases) {
  std::vector<double> out;
  for (const CloudProbe::Column& c : probe.column(cases)) out.push_back(1.0 - std::exp(-total_depth(c)));
  return out;
}

TEST_CASE("gpu: one time has one sky to the last bit, in whatever order times are asked for") {
  GpuFixture gpu;
  CloudParams params;
  params.layers = {genus_layer("cumulus"), genus_layer("cirrus")};
  const Clouds first(gpu.device, params);
  CloudProbe probe(gpu.device, first);
  const std::vector<double> times = {8.4e8, 8.4e8 + 600.0, 8.4e8 + 86400.0, 8.4e8 - 3e6,
                                     std::ceil(8.4e8 / kWindow_s) * kWindow_s};
  std::vector<std::vector<CloudProbe::Column>> forward(times.size()), backward(times.size());
  const auto at = [&](CloudProbe& by, double t) { return by.column(square_cases({35.5, 138.7}, 40e3, 24, 50.0, t)); };
  for (size_t i = 0; i < times.size(); ++i) forward[i] = at(probe, times[i]);
  const Clouds second(gpu.device, params);  // another run of the program
  CloudProbe other(gpu.device, second);
  for (size_t i = times.size(); i-- > 0;) backward[i] = at(other, times[i]);
  for (size_t i = 0; i < times.size(); ++i) {
    bool same = true;
    for (size_t k = 0; k < forward[i].size(); ++k)
      same = same && forward[i][k].optical_depth == backward[i][k].optical_depth;
    CHECK(same);
  }
  // Other times are other skies.
  double apart = 0.0;
  for (size_t k = 0; k < forward[0].size(); ++k)
    apart += std::abs(total_depth(forward[0][k]) - total_depth(forward[2][k]));
  CHECK(apart > 1.0);
}

TEST_CASE("gpu: winds carry the field by their speed times the time, east and north, at several latitudes") {
  GpuFixture gpu;
  CloudParams params = genus_sky("cumulus", 0.5);
  params.layers[0].evolution_speed = 0.0;
  constexpr double kSide_m = 25.6e3, kLater_s = 600.0;
  constexpr size_t kPixels = 64;
  for (const glm::dvec2 wind : {glm::dvec2(8.0, 0.0), glm::dvec2(0.0, -6.0), glm::dvec2(5.0, 7.0)}) {
    params.layers[0].wind_east_mps = wind.x;
    params.layers[0].wind_north_mps = wind.y;
    const Clouds clouds(gpu.device, params);
    CloudProbe probe(gpu.device, clouds);
    std::string line;
    for (const Place& place : {Place{0.0, 20.0}, Place{-38.0, -70.0}, Place{64.0, 100.0}, Place{84.0, 10.0}}) {
      // Four hours after the middle of a window: the field has moved 100 km already.
      const double t = kQuietTime_s + 4.0 * 3600.0;
      const Grid a = opacity(depth_grid(probe, place, kSide_m, kPixels, 200.0, t));
      const Grid b = opacity(depth_grid(probe, place, kSide_m, kPixels, 200.0, t + kLater_s));
      const Displacement d = displacement(a, b, 20);
      const double pixel_m = kSide_m / static_cast<double>(kPixels);
      const glm::dvec2 found(d.dx * pixel_m / kLater_s, d.dy * pixel_m / kLater_s);
      char text[100];
      std::snprintf(text, sizeof text, " lat %.0f: %.2f %.2f (r %.3f)", place.lat_deg, found.x, found.y, d.peak);
      line += text;
      CAPTURE(place.lat_deg);
      // Winds fade near the poles, where east has no direction (docs/clouds.md).
      const double lat = rad_from_deg(place.lat_deg), speed = glm::length(wind);
      const glm::dvec2 expected = wind * (std::cos(lat) / std::sqrt(std::cos(lat) * std::cos(lat) + 0.0025));
      // A few per cent, a tenth of a pixel, and what the turning of east does to a field that was carried straight on
      // for four hours.
      const double turning = speed * (speed * 4.0 * 3600.0 * std::abs(std::tan(lat)) / 6378e3);
      CHECK(glm::length(found - expected) < 0.03 * speed + 0.1 * pixel_m / kLater_s + turning);
      CHECK(d.peak > 0.7);
    }
    MESSAGE("wind ", wind.x, " east ", wind.y, " north, m/s:", line);
  }
}

TEST_CASE("gpu: cells form and dissolve in about 40 minutes at evolution_speed 1, in proportion to it, and not at 0") {
  GpuFixture gpu;
  CloudParams params = genus_sky("cumulus", 0.4);
  params.layers[0].wind_east_mps = 0.0;
  const auto likeness = [&](double speed, double after_s) {
    params.layers[0].evolution_speed = speed;
    const Clouds clouds(gpu.device, params);
    CloudProbe probe(gpu.device, clouds);
    const double t = kQuietTime_s - 7200.0;
    return correlation(opacities(probe, square_cases({35.5, 138.7}, 60e3, 48, 200.0, t)),
                       opacities(probe, square_cases({35.5, 138.7}, 60e3, 48, 200.0, t + after_s)));
  };
  const double ten = likeness(1.0, 600.0), forty = likeness(1.0, 2400.0), hours = likeness(1.0, 7200.0);
  const double quick = likeness(4.0, 600.0), still = likeness(0.0, 7200.0);
  MESSAGE("correlation after 10 min ", ten, ", 40 min ", forty, ", 2 h ", hours, "; fourfold after 10 min ", quick);
  CHECK(still == doctest::Approx(1.0));
  CHECK(ten > 0.4);
  CHECK(ten < 0.95);
  CHECK(forty < 0.45);
  CHECK(hours < forty);
  CHECK(std::abs(quick - forty) < 0.15);  // other cells, the same statistics
}

TEST_CASE("gpu: nothing jumps where a window of patterns ends, and the cover and its variance stay while two overlap") {
  GpuFixture gpu;
  CloudParams params = genus_sky("cumulus", 0.5);
  const Clouds clouds(gpu.device, params);
  CloudProbe probe(gpu.device, clouds);
  const double end = 21.0 * kWindow_s, half = 0.5 * kWindowOverlap_s;
  CHECK(cloud_phases(end - half - 1.0).count == 1);
  CHECK(cloud_phases(end).count == 2);
  const auto at = [&](double t) { return opacities(probe, square_cases({35.5, 138.7}, 60e3, 48, 100.0, t)); };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
    return sum / static_cast<double>(a.size());
  };
  // A second, at the overlap's start, the window's end and the overlap's end: each as in the overlap's middle.
  std::string line;
  const double usual = apart(at(end + 100.0), at(end + 101.0));
  for (const double when : {end - half, end, end + half}) {
    const double jump = apart(at(when - 0.5), at(when + 0.5));
    line += " " + std::to_string(jump);
    CHECK(jump < 2.0 * usual);
  }
  MESSAGE("mean change of opacity in a second: ", usual, "; at the seams:", line);
  // Cover in 16 wide squares, before and amid.
  const auto cover = [&](double t) {
    double covered = 0.0, count = 0.0, square = 0.0, sum = 0.0;
    for (int place = 0; place < 16; ++place)
      for (const CloudProbe::Column& c :
           probe.column(square_cases({-70.0 + 9.0 * place, 77.0 * place - 180.0}, 300e3, 16, 10.0, t))) {
        covered += total_depth(c) > 1.0;
        sum += std::log1p(total_depth(c));
        square += std::pow(std::log1p(total_depth(c)), 2);
        count += 1.0;
      }
    return std::pair(covered / count, square / count - sum * sum / (count * count));
  };
  const auto before = cover(end - 3.0 * half), amid = cover(end), quarter = cover(end - 0.5 * half);
  MESSAGE("cover before ", before.first, ", at a quarter ", quarter.first, ", amid ", amid.first,
          "; variance of log depth ", before.second, ", ", quarter.second, ", ", amid.second);
  for (const auto& now : {before, quarter, amid}) {
    CHECK(std::abs(now.first - 0.5) < 0.05);
    CHECK(now.second == doctest::Approx(before.second).epsilon(0.1));
  }
}

}  // namespace
}  // namespace nepho::test
