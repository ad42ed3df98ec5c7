#pragma once
// Inside src/rasters only: nothing of GDAL leaves this folder.
#include <cmath>
#include <string>

#include "rasters/gdal_support.h"

namespace nepho {

/// Dataset pixels to longitude and latitude, however the dataset is placed.
class PixelToLonLat {
 public:
  /// `assume_degrees`: its control points are degrees, although no CRS says so.
  PixelToLonLat(GDALDataset& dataset, bool assume_degrees);
  ~PixelToLonLat();
  PixelToLonLat(const PixelToLonLat&) = delete;
  PixelToLonLat& operator=(const PixelToLonLat&) = delete;
  explicit operator bool() const { return transformer_ != nullptr; }
  /// In place; false for a point that has no place.
  bool forward(double& x, double& y) const { return transform(FALSE, x, y); }
  bool inverse(double& x, double& y) const { return transform(TRUE, x, y); }

 private:
  bool transform(int to_pixels, double& x, double& y) const;
  void* transformer_ = nullptr;
};

/// Whether control points without a CRS have to be taken as degrees.
bool needs_assumed_degrees(GDALDataset& dataset);

std::string crs_name(const OGRSpatialReference& srs);

/// A difference of longitudes, -180..180.
inline double wrapped_degrees(double difference) { return std::remainder(difference, 360.0); }

}  // namespace nepho
