#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/types.h"
#include "render/reference_shared.h"

namespace nepho {

/// How many paths each pixel of a reference gets, and in which rounds. A pixel has traced ceil(share_i * level) paths
/// at a level that rises; the levels at which the noise is looked at are fixed, so that the same scene gives the same
/// picture however fast the machine is.
class SamplePlan {
 public:
  /// As many for every pixel: level is the number of paths.
  static SamplePlan even(size_t pixels);
  /// As many as each pixel needs for the relative standard error `noise`, judged by a pilot's sums and those of its
  /// neighbours: level 1 is that number. The pilot's own paths must not go into the picture: a pixel that
  /// happened to miss its rare bright paths would get fewer.
  static SamplePlan by_need(std::span<const shared::PixelSums> pilot, Extent2D extent, double noise);
  /// In proportion to what a picture has; level 1 is that.
  static SamplePlan like(std::span<const shared::PixelSums> earlier);

  /// Paths of pixel i at a level.
  uint32_t at(size_t pixel, double level) const;
  /// The level at which the noise is to be looked at after one.
  double next_check(double level) const;
  /// The next round from `level` towards `goal`: new paths of every pixel, at most `most_paths` in all and
  /// `most_samples` a pixel. Returns the level reached.
  double round(double level, double goal, uint64_t most_paths, uint32_t most_samples,
               std::vector<uint32_t>& samples) const;
  bool is_even() const { return share_.empty(); }
  uint64_t paths(double level) const;  ///< of all pixels

 private:
  size_t pixels_ = 0;
  std::vector<float> share_;  ///< empty: 1
};

}  // namespace nepho
