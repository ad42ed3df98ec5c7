#include "render/sample_plan.h"

#include <algorithm>
#include <cmath>

#include "common/tonemap.h"

namespace nepho {
namespace {

constexpr double kFirstCheck = 16.0;  // of even plans, in paths
constexpr float kFewest = 32.0f, kMost = 1.0e6f;
constexpr double kLeastOfMean = 0.25;
/// A pixel aims a little below the noise asked for: a twentieth of them may stay above.
constexpr double kAim = 0.95;

/// A pilot's variances are uncertain: a pixel's own counts so much, the mean of those around it the rest.
constexpr float kOwn = 0.3f;
constexpr int kAround = 2;  // px

/// Relative variance of one path's luminance; 0 of black pixels.
float relative_variance(const shared::PixelSums& s) {
  const float y = shared::luminance(s.mean);
  if (s.paths < 2.0f || !(std::abs(y) > 0.0f)) return 0.0f;
  return s.y_squares / (s.paths - 1.0f) / (y * y);
}

}  // namespace

SamplePlan SamplePlan::even(size_t pixels) {
  SamplePlan plan;
  plan.pixels_ = pixels;
  return plan;
}

SamplePlan SamplePlan::by_need(std::span<const shared::PixelSums> pilot, Extent2D extent, double noise) {
  SamplePlan plan = even(pilot.size());
  std::vector<float> own(pilot.size());
  for (size_t i = 0; i < own.size(); ++i) own[i] = relative_variance(pilot[i]);
  plan.share_.resize(own.size());
  const int w = static_cast<int>(extent.width), h = static_cast<int>(extent.height);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float sum = 0.0f, n = 0.0f;
      for (int j = std::max(y - kAround, 0); j <= std::min(y + kAround, h - 1); ++j)
        for (int i = std::max(x - kAround, 0); i <= std::min(x + kAround, w - 1); ++i) {
          sum += own[static_cast<size_t>(j * w + i)];
          n += 1.0f;
        }
      const auto at = static_cast<size_t>(y * w + x);
      const float variance = kOwn * own[at] + (1.0f - kOwn) * sum / n;
      const auto needed = static_cast<float>(static_cast<double>(variance) / std::pow(kAim * noise, 2.0));
      plan.share_[at] = std::clamp(needed, kFewest, kMost);
    }
  // A thin veil that the pilot's paths all passed by must not show as a bright point: one hit among many paths is little.
  double sum = 0.0;
  for (const float share : plan.share_) sum += static_cast<double>(share);
  const auto least = static_cast<float>(kLeastOfMean * sum / static_cast<double>(plan.share_.size()));
  for (float& share : plan.share_) share = std::max(share, least);
  return plan;
}

SamplePlan SamplePlan::like(std::span<const shared::PixelSums> earlier) {
  SamplePlan plan = even(earlier.size());
  const bool all_equal = std::all_of(earlier.begin(), earlier.end(),
                                     [&](const shared::PixelSums& s) { return s.paths == earlier.front().paths; });
  if (all_equal) return plan;
  for (const shared::PixelSums& s : earlier) plan.share_.push_back(std::max(s.paths, 1.0f));
  return plan;
}

uint32_t SamplePlan::at(size_t pixel, double level) const {
  const double share = share_.empty() ? 1.0 : static_cast<double>(share_[pixel]);
  return static_cast<uint32_t>(std::ceil(share * level - 1e-9));
}

double SamplePlan::next_check(double level) const {
  if (share_.empty()) return level < kFirstCheck ? kFirstCheck : std::ceil(1.2 * level);
  return level < 0.499 ? 0.5 : level + 0.1;
}

uint64_t SamplePlan::paths(double level) const {
  if (share_.empty()) return pixels_ * static_cast<uint64_t>(at(0, level));
  uint64_t sum = 0;
  for (size_t i = 0; i < share_.size(); ++i) sum += at(i, level);
  return sum;
}

double SamplePlan::round(double level, double goal, uint64_t most_paths, uint32_t most_samples,
                         std::vector<uint32_t>& samples) const {
  samples.resize(pixels_);
  const float largest = share_.empty() ? 1.0f : *std::max_element(share_.begin(), share_.end());
  double reached = std::min(goal, level + most_samples / static_cast<double>(largest));
  if (share_.empty()) reached = std::max(std::floor(reached), level + 1.0);
  const uint64_t before = paths(level);
  // Halved until it fits; a pixel's path or two at least.
  while (paths(reached) - before > most_paths) {
    const double less = level + 0.5 * (reached - level);
    const double step = share_.empty() ? std::max(std::floor(less), level + 1.0) : less;
    if (step >= reached || paths(step) == before) break;
    reached = step;
  }
  for (size_t i = 0; i < pixels_; ++i) samples[i] = at(i, reached) - at(i, level);
  return reached;
}

}  // namespace nepho
