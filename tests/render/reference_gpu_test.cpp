// Pictures of quality reference: free of bias, with an error that is what their variance says.
#include <algorithm>

#include "render/reference_scene.h"
#include "render/sample_plan.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// The first level not below `paths` at which an even picture may end.
double level_from(double paths) {
  const SamplePlan plan = SamplePlan::even(1);
  double level = 0.0;
  while (level < paths) level = plan.next_check(level);
  return level;
}

/// A picture's green, and the variance of its mean.
struct Green {
  std::vector<float> mean, variance, samples;
  explicit Green(const ImageBuffer& image)
      : mean(channel(image, "G")), variance(channel(image, "variance.G")), samples(channel(image, "samples")) {}
  double difference(const Green& other, size_t i) const {
    return static_cast<double>(mean[i]) - static_cast<double>(other.mean[i]);
  }
  double variance_with(const Green& other, size_t i) const {
    return static_cast<double>(variance[i]) + static_cast<double>(other.variance[i]);
  }
};

/// Slope of a line through (x, y), least squares.
double slope_of(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace

TEST_CASE(
    "gpu: the same seed gives the same paths however they are cut; the error falls as 1 / sqrt N and has no outliers") {
  GpuFixture f;
  const bool full = full_size();
  const Extent2D size = full ? Extent2D{16, 12} : Extent2D{8, 6};
  CloudParams clouds = half_sky("cumulus");
  clouds.layers[0].thickness_m = full ? 1600.0 : 500.0;  // fewer scatterings
  Renderer first(f.device, {}, reference_scene(clouds, size, 1)),
      second(f.device, {}, reference_scene(clouds, size, 2));
  std::vector<double> levels = {16.0, level_from(120.0), level_from(900.0)};
  if (full) levels.push_back(level_from(16000.0));

  const ImageBuffer at_once = draw_to(first, 24.0);
  ImageBuffer a = draw_to(first, levels[0]), b = draw_to(second, levels[0]);
  {
    const ImageBuffer again = draw_to(first, levels[0]), resumed = draw_to(first, 24.0, &a);
    CHECK(channel(again, "G") == channel(a, "G"));
    CHECK(channel(again, "variance.R") == channel(a, "variance.R"));
    for (const char* name : {"R", "G", "B", "cloud.G", "variance.G", "samples"}) {
      const std::vector<float>&x = channel(at_once, name), &y = channel(resumed, name);
      double worst = 0.0;
      for (size_t i = 0; i < x.size(); ++i)
        worst = std::max(
            worst, static_cast<double>(std::abs(x[i] - y[i])) / std::max(std::abs(static_cast<double>(x[i])), 1e-6));
      CHECK_MESSAGE(worst <= 1e-5, name);
      if (std::string(name) == "samples") CHECK(std::all_of(y.begin(), y.end(), [](float n) { return n == 24.0f; }));
    }
  }

  std::vector<Green> as{Green(a)}, bs{Green(b)};
  for (size_t k = 1; k < levels.size(); ++k) {
    a = draw_to(first, levels[k], &a);
    b = draw_to(second, levels[k], &b);
    as.emplace_back(a);
    bs.emplace_back(b);
  }
  std::vector<double> log_n, log_error;
  for (size_t k = 0; k < levels.size(); ++k) {
    double sum = 0.0;
    for (size_t i = 0; i < as[k].mean.size(); ++i) {
      // In units of each pixel's own deviation, so that all count alike.
      const double one_path = levels.back() * as.back().variance_with(bs.back(), i);
      const double d = as[k].difference(bs[k], i);
      if (one_path > 0.0) sum += d * d / one_path;
    }
    log_n.push_back(std::log(levels[k]));
    log_error.push_back(0.5 * std::log(sum / static_cast<double>(as[k].mean.size())));
    MESSAGE(levels[k], " paths: rms of two seeds' difference ", std::exp(log_error.back()), " of a path's deviation");
  }
  const double slope = slope_of(log_n, log_error);
  MESSAGE("error falls with the power ", slope);
  CHECK(std::abs(slope + 0.5) < (full ? 0.04 : 0.08));

  // Against another seed's picture of seven and more times as many paths.
  const size_t from = full ? 2 : 1;
  double worst = 0.0;
  for (const auto& [fewer, more] : {std::pair{&as[from], &bs[from + 1]}, std::pair{&bs[from], &as[from + 1]}})
    for (size_t i = 0; i < fewer->mean.size(); ++i) {
      const double error = std::sqrt(static_cast<double>(fewer->variance[i]));
      worst = std::max(worst, std::abs(fewer->difference(*more, i)) / std::max(error, 1e-6));
    }
  MESSAGE("pixel farthest from its final value: ", worst, " standard errors");
  CHECK(worst <= 8.0);
}

TEST_CASE("gpu: pictures of two seeds agree within their noise") {
  GpuFixture f;
  const Extent2D size = full_size() ? Extent2D{96, 64} : Extent2D{24, 16};
  const double level = level_from(full_size() ? 200.0 : 60.0);
  std::vector<Green> pictures;
  ImageBuffer image;
  for (const uint32_t seed : {11u, 12u}) {
    Renderer renderer(f.device, {}, reference_scene(half_sky("cumulus"), size, seed));
    image = draw_to(renderer, level);
    pictures.emplace_back(image);
    CHECK(renderer.timings().reference.overruns == 0);
  }
  const std::vector<float>& through = channel(image, "cloud.transmittance");
  const Green &a = pictures[0], &b = pictures[1];
  double squares = 0.0, sum = 0.0, variance = 0.0;
  size_t cloudy = 0, within = 0;
  for (size_t i = 0; i < a.mean.size(); ++i) {
    sum += a.difference(b, i);
    variance += a.variance_with(b, i);
    if (through[i] > 0.99f) continue;
    const double z2 = std::pow(a.difference(b, i), 2.0) / a.variance_with(b, i);
    squares += z2;
    within += z2 <= 9.0 ? 1 : 0;
    ++cloudy;
  }
  const auto n = static_cast<double>(cloudy);
  MESSAGE(level, " paths, ", cloudy, " pixels of cloud: mean Z^2 ", squares / n, ", within 3 sigma ",
          static_cast<double>(within) / n, ", mean of the picture ", sum / std::sqrt(variance), " standard errors");
  CHECK(cloudy > a.mean.size() / 3);
  CHECK(static_cast<double>(within) / n >= 0.99);
  CHECK(squares / n > 0.8);
  CHECK(squares / n < 1.25);
  CHECK(std::abs(sum) <= 4.0 * std::sqrt(variance));
}
