#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "io/raster.h"

namespace nepho {

/// A raster at one of its reductions, whole, in memory, to be averaged onto the sphere: round the antimeridian, over
/// the poles, and only where it has data.
class LonLatGrid {
 public:
  /// Reads all blocks of a reduction. Throws Error(input) with the raster's own reason when one cannot be read.
  /// `change` is applied to every block.
  LonLatGrid(const Raster& raster, uint32_t reduction, const std::function<void(RasterBlock&)>& change = {});

  /// The largest reduction whose pixels are no larger than `pixel_deg`, or the next that keeps the number of values
  /// below some 50 million.
  static uint32_t reduction_for(const Raster& raster, double pixel_deg);

  uint32_t channels() const { return channels_; }
  bool global() const { return wraps_ && reaches_north_ && reaches_south_; }

  /// What separate_outside() found.
  struct Gaps {
    double holes = 0.0;     ///< share of the pixels without data, those outside left out
    bool any_data = false;  ///< some pixel has data
  };
  /// Calls pixels without data that are connected to an open edge of the raster outside, all others holes.
  Gaps separate_outside();
  /// Fills holes from around them: means of growing squares, coarse to fine (push and pull).
  void fill_holes();
  /// Lets what is inside fade to 0 towards an open edge within `width_deg`.
  void soften_edges(double width_deg);

  /// Mean over a tent of half width `half_deg` of great circle (at least one pixel) in `out[channels]`, of the pixels
  /// with data; returns the share of the tent that has data. Any longitude; latitude is geodetic.
  double sample(double lat_deg, double lon_deg, double half_deg, float* out) const;

 private:
  double row_lat_deg(uint32_t row) const { return north_deg_ - centre_of(row, height_, span_rows_) * lat_step_deg_; }
  static double centre_of(uint32_t i, uint32_t count, double span);
  void add_row(uint32_t row, double row_weight, double lon_deg, double half_deg, double* sums) const;
  double sample_polar(double lat_deg, double lon_deg, double half_deg, float* out) const;
  bool beyond_reach(double lat_deg, double lon_deg, double half_deg) const;

  uint32_t width_ = 0, height_ = 0, channels_ = 1;
  double west_deg_ = 0.0, north_deg_ = 0.0, lon_step_deg_ = 1.0, lat_step_deg_ = 1.0;
  double span_columns_ = 0.0, span_rows_ = 0.0;  // extent in pixels; the last of them may be a part of one
  bool wraps_ = false, reaches_north_ = false, reaches_south_ = false;
  std::vector<float> values_;
  std::vector<double> cos_lat_;  // of rows
  std::vector<uint8_t> state_;   // 0 a hole, 1 data, 2 outside
};

}  // namespace nepho
