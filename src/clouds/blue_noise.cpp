#include "clouds/blue_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace nepho {
namespace {

constexpr uint32_t kSize = kBlueSize, kSlices = kBlueSlices, kSlice = kSize * kSize, kCount = kSlice * kSlices;
constexpr uint32_t kRows = kSize * kSlices;
constexpr int32_t kReach = 7;           // of the kernel in the plane, px
constexpr double kSigma = 1.9;          // px, of both Gaussians
constexpr int32_t kUnit = 1 << 20;      // energy 1; whole numbers, so that what is added can be taken away exactly
constexpr int32_t kOccupied = 1 << 29;  // on top of a point's energy: clusters are maxima, voids are minima

int32_t kernel(int32_t squared_distance) {
  return static_cast<int32_t>(std::lround(kUnit * std::exp(-squared_distance / (2.0 * kSigma * kSigma))));
}

uint32_t hash(uint32_t v) {  // PCG, Jarzynski and Olano 2020
  v = v * 747796405u + 2891336453u;
  v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
  return (v >> 22u) ^ v;
}

/// Points and the energy that they spread, with the extremes of every row kept up to date.
class Pattern {
 public:
  Pattern() : energy_(kCount) {
    for (int32_t dy = -kReach; dy <= kReach; ++dy)
      for (int32_t dx = -kReach; dx <= kReach; ++dx)
        plane_[static_cast<size_t>(dy + kReach)][static_cast<size_t>(dx + kReach)] = kernel(dx * dx + dy * dy);
    for (uint32_t t = 1; t < kSlices; ++t) {
      const auto d = static_cast<int32_t>(std::min(t, kSlices - t));
      time_[t] = kernel(d * d);
    }
    for (uint32_t i = 0; i < kCount; ++i) energy_[i] = static_cast<int32_t>(hash(i) & 1023u);  // breaks ties
    for (uint32_t row = 0; row < kRows; ++row) refresh(row);
  }
  bool occupied(uint32_t site) const { return energy_[site] >= kOccupied; }
  void add(uint32_t site) { spread(site, 1); }
  void remove(uint32_t site) { spread(site, -1); }
  uint32_t tightest_cluster() const {
    return locate(std::max_element(high_.begin(), high_.end()) - high_.begin(), true);
  }
  uint32_t largest_void() const { return locate(std::min_element(low_.begin(), low_.end()) - low_.begin(), false); }

 private:
  void spread(uint32_t site, int32_t sign) {
    const uint32_t x = site % kSize, y = site / kSize % kSize, slice = site / kSlice;
    energy_[site] += sign * kOccupied;
    for (uint32_t ky = 0; ky < plane_.size(); ++ky) {
      const uint32_t row = slice * kSize + (y + ky + kSize - static_cast<uint32_t>(kReach)) % kSize;
      for (uint32_t kx = 0; kx < plane_.size(); ++kx)
        energy_[row * kSize + (x + kx + kSize - static_cast<uint32_t>(kReach)) % kSize] += sign * plane_[ky][kx];
      refresh(row);
    }
    for (uint32_t t = 1; t < kSlices; ++t) {
      const uint32_t row = (slice + t) % kSlices * kSize + y;
      energy_[row * kSize + x] += sign * time_[t];
      refresh(row);
    }
  }
  void refresh(uint32_t row) {
    const int32_t* of = &energy_[row * kSize];
    int32_t low = of[0], high = of[0];
    for (uint32_t x = 0; x < kSize; ++x) {
      low = std::min(low, of[x]);
      high = std::max(high, of[x]);
    }
    low_[row] = low;
    high_[row] = high;
  }
  uint32_t locate(std::ptrdiff_t row, bool high) const {
    const auto begin = energy_.begin() + row * static_cast<std::ptrdiff_t>(kSize);
    const int32_t value = high ? high_[static_cast<size_t>(row)] : low_[static_cast<size_t>(row)];
    return static_cast<uint32_t>(std::find(begin, begin + kSize, value) - energy_.begin());
  }
  std::vector<int32_t> energy_;
  std::array<int32_t, kRows> low_{}, high_{};
  std::array<std::array<int32_t, 2 * kReach + 1>, 2 * kReach + 1> plane_{};
  std::array<int32_t, kSlices> time_{};
};

}  // namespace

bool equalise_slices(const std::vector<float>& values, std::vector<uint8_t>& equalised) {
  NEPHO_ASSERT_OP(values.size(), ==, size_t{kCount});
  equalised.resize(kCount);
  std::vector<uint32_t> order(kSlice);
  for (uint32_t slice = 0; slice < kSlices; ++slice) {
    const float* of = &values[slice * kSlice];
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return of[a] != of[b] ? of[a] < of[b] : a < b; });
    if (of[order.front()] == of[order.back()]) return false;
    for (uint32_t first = 0; first < kSlice;) {
      uint32_t end = first + 1;
      while (end < kSlice && of[order[end]] == of[order[first]]) ++end;
      const uint32_t level = (first + end) / 2 * 256 / kSlice;
      for (; first < end; ++first) equalised[slice * kSlice + order[first]] = static_cast<uint8_t>(level);
    }
  }
  return true;
}

std::vector<uint8_t> make_blue_noise() {
  Pattern pattern;
  uint32_t placed = 0;
  for (uint32_t i = 0; i < kCount; ++i)
    if (hash(hash(i) + 1u) < 0xffffffffu / 10u) {
      pattern.add(i);
      ++placed;
    }
  // Until the point of the tightest cluster is what fills the largest void.
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint32_t from = pattern.tightest_cluster();
    pattern.remove(from);
    const uint32_t to = pattern.largest_void();
    pattern.add(to);
    if (from == to) break;
  }
  std::vector<float> rank(kCount);
  Pattern thinning = pattern;
  for (uint32_t i = placed; i-- > 0;) {
    const uint32_t site = thinning.tightest_cluster();
    thinning.remove(site);
    rank[site] = static_cast<float>(i);
  }
  // Beyond half, Ulichney looks for clusters of empty sites; their energy is a constant minus that of the points, so
  // these are the largest voids all the way.
  for (uint32_t i = placed; i < kCount; ++i) {
    const uint32_t site = pattern.largest_void();
    pattern.add(site);
    rank[site] = static_cast<float>(i);
  }
  std::vector<uint8_t> noise;
  equalise_slices(rank, noise);
  return noise;
}

}  // namespace nepho
