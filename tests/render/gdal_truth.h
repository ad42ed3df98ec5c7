#pragma once
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace nepho {

/// A raster as GDAL itself reads it, at its own pixels: what pictures of the ground are checked against. Shares no code
/// with the modules rasters and terrain. Datasets without georeference are global.
class GdalTruth {
 public:
  explicit GdalTruth(const std::string& path) {
    GDALAllRegister();
    dataset_.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
    if (!dataset_) return;
    OGRSpatialReference wgs84;
    wgs84.SetWellKnownGeogCS("WGS84");
    wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    std::array<double, 6> forward{};
    if (dataset_->GetGeoTransform(forward.data()) != CE_None)
      forward = {-180.0, 360.0 / dataset_->GetRasterXSize(), 0.0, 90.0, 0.0, -180.0 / dataset_->GetRasterYSize()};
    if (!GDALInvGeoTransform(forward.data(), inverse_.data())) dataset_.reset();
    if (const OGRSpatialReference* srs = dataset_->GetSpatialRef()) {
      OGRSpatialReference own(*srs);
      own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
      from_lonlat_.reset(OGRCreateCoordinateTransformation(&wgs84, &own));
      to_lonlat_.reset(OGRCreateCoordinateTransformation(&own, &wgs84));
    }
    forward_ = forward;
  }
  bool good() const { return dataset_ != nullptr; }

  struct Pixel {
    double x = 0.0, y = 0.0;  ///< the first pixel's centre is 0.5, 0.5
  };
  Pixel pixel_at(double lat_deg, double lon_deg) const {
    double x = lon_deg, y = lat_deg;
    if (from_lonlat_) from_lonlat_->Transform(1, &x, &y);
    return {inverse_[0] + inverse_[1] * x + inverse_[2] * y, inverse_[3] + inverse_[4] * x + inverse_[5] * y};
  }
  /// Latitude and longitude of a pixel, degrees.
  std::array<double, 2> place_of(double px, double py) const {
    double x = forward_[0] + forward_[1] * px + forward_[2] * py, y = forward_[3] + forward_[4] * px + forward_[5] * py;
    if (to_lonlat_) to_lonlat_->Transform(1, &x, &y);
    return {y, x};
  }
  int width() const { return dataset_->GetRasterXSize(); }
  int height() const { return dataset_->GetRasterYSize(); }
  /// The shorter side of a pixel at a place, m on the ground.
  double pixel_m(double px, double py) const {
    const auto at = place_of(px, py), down = place_of(px, py + 1.0), aside = place_of(px + 1.0, py);
    const double cos_lat = std::cos(at[0] * 3.14159265358979 / 180.0);
    const auto length = [&](const std::array<double, 2>& to) {
      return 111.2e3 * std::hypot(to[0] - at[0], (to[1] - at[1]) * cos_lat);
    };
    return std::min(length(down), length(aside));
  }

  struct Range {
    double low = 1e300, high = -1e300;
    double at = 0.0;  ///< of the nearest sample
  };
  /// Bilinear between pixel centres; empty at the edge and where a sample is no data.
  std::optional<double> bilinear(double lat_deg, double lon_deg, double shift_x = 0.0, double shift_y = 0.0) {
    if (band_.empty()) read_band();
    const Pixel p = pixel_at(lat_deg, lon_deg);
    const double x = p.x + shift_x - 0.5, y = p.y + shift_y - 0.5;
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 + 1 >= width() || y0 + 1 >= height()) return std::nullopt;
    const auto v = [&](int i, int j) {
      return band_[static_cast<size_t>(y0 + j) * static_cast<size_t>(width()) + static_cast<size_t>(x0 + i)];
    };
    const double value = (1 - fy) * ((1 - fx) * v(0, 0) + fx * v(1, 0)) + fy * ((1 - fx) * v(0, 1) + fx * v(1, 1));
    if (std::isnan(value)) return std::nullopt;
    return value;
  }
  /// A band's value between the four samples around, bilinear; empty at the edge.
  std::optional<double> between(double lat_deg, double lon_deg, int band) const {
    const Pixel p = pixel_at(lat_deg, lon_deg);
    const double x = p.x - 0.5, y = p.y - 0.5, fx = x - std::floor(x), fy = y - std::floor(y);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 + 1 >= width() || y0 + 1 >= height()) return std::nullopt;
    double v[4];
    GDALRasterBand* b = dataset_->GetRasterBand(std::min(band, dataset_->GetRasterCount()));
    if (b->RasterIO(GF_Read, x0, y0, 2, 2, v, 2, 2, GDT_Float64, 0, 0) != CE_None) return std::nullopt;
    return (1 - fy) * ((1 - fx) * v[0] + fx * v[1]) + fy * ((1 - fx) * v[2] + fx * v[3]);
  }
  /// The samples within `reach` of the nearest one; empty at the edge and where one of them is no data.
  std::optional<Range> around(double lat_deg, double lon_deg, int band, int reach) const {
    const Pixel p = pixel_at(lat_deg, lon_deg);
    const int x0 = static_cast<int>(std::floor(p.x)) - reach, y0 = static_cast<int>(std::floor(p.y)) - reach;
    const int n = 2 * reach + 1;
    if (x0 < 0 || y0 < 0 || x0 + n > width() || y0 + n > height()) return std::nullopt;
    std::vector<double> values(static_cast<size_t>(n) * static_cast<size_t>(n));
    std::vector<unsigned char> mask(values.size());
    GDALRasterBand* b = dataset_->GetRasterBand(std::min(band, dataset_->GetRasterCount()));
    if (b->RasterIO(GF_Read, x0, y0, n, n, values.data(), n, n, GDT_Float64, 0, 0) != CE_None) return std::nullopt;
    if (b->GetMaskBand()->RasterIO(GF_Read, x0, y0, n, n, mask.data(), n, n, GDT_Byte, 0, 0) != CE_None)
      return std::nullopt;
    if (std::any_of(mask.begin(), mask.end(), [](unsigned char m) { return m != 255; })) return std::nullopt;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return Range{*low, *high, values[values.size() / 2]};
  }

 private:
  /// The first band, NaN where there is no data.
  void read_band() {
    band_.resize(static_cast<size_t>(width()) * static_cast<size_t>(height()));
    std::vector<unsigned char> mask(band_.size());
    GDALRasterBand* b = dataset_->GetRasterBand(1);
    const bool good =
        b->RasterIO(GF_Read, 0, 0, width(), height(), band_.data(), width(), height(), GDT_Float64, 0, 0) == CE_None &&
        b->GetMaskBand()->RasterIO(GF_Read, 0, 0, width(), height(), mask.data(), width(), height(), GDT_Byte, 0, 0) ==
            CE_None;
    for (size_t i = 0; i < band_.size(); ++i)
      if (!good || mask[i] == 0) band_[i] = std::numeric_limits<double>::quiet_NaN();
  }
  struct Close {
    void operator()(GDALDataset* d) const { GDALClose(d); }
    void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
  };
  std::unique_ptr<GDALDataset, Close> dataset_;
  std::unique_ptr<OGRCoordinateTransformation, Close> from_lonlat_, to_lonlat_;
  std::vector<double> band_;
  std::array<double, 6> forward_{}, inverse_{};
};

}  // namespace nepho
