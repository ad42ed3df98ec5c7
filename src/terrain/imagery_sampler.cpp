#include "terrain/imagery_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "terrain/raster_window.h"

namespace nepho {

namespace {

constexpr float kNoImagery = 124.0f;     // sRGB of albedo 0.2
constexpr uint32_t kFillReductions = 5;  // land colours are looked for as far as 2^5 texels away

/// Four floats at once: a colour.
using Colour = float __attribute__((vector_size(16)));

Colour load(const float* p) { return Colour{p[0], p[1], p[2], 0.0f}; }
Colour load_grey(const float* p) { return Colour{p[0], p[0], p[0], 0.0f}; }

}  // namespace

RasterCoverage lay_over(const BlockCache& raster, uint32_t reduction, std::span<const double> lat_deg,
                        std::span<const double> lon_deg, float* rgbx) {
  const RasterAxis x = columns_at(raster, reduction, lon_deg), y = rows_at(raster, reduction, lat_deg);
  if (!x.any_inside || !y.any_inside) return RasterCoverage::none;
  RasterWindow w;
  gather(raster, reduction, x, y, w);
  if (w.none_valid) return RasterCoverage::none;
  const size_t bands = w.bands;
  const auto at = [&](size_t row, size_t column) {
    const float* p = &w.values[(row * w.columns + column) * bands];
    return bands >= 3 ? load(p) : load_grey(p);
  };
  for (size_t j = 0; j < lat_deg.size(); ++j) {
    const RasterAxis::Tap ty = y.taps[j];
    const auto fy = static_cast<float>(ty.f);
    const uint8_t* valid_a = &w.valid[size_t{ty.a} * w.columns];
    const uint8_t* valid_b = &w.valid[size_t{ty.b} * w.columns];
    for (size_t i = 0; i < lon_deg.size(); ++i) {
      const RasterAxis::Tap tx = x.taps[i];
      const auto fx = static_cast<float>(tx.f);
      float* out = rgbx + (j * lon_deg.size() + i) * 4;
      if (w.all_valid) {
        const Colour top = at(ty.a, tx.a) * (1.0f - fx) + at(ty.a, tx.b) * fx;
        const Colour low = at(ty.b, tx.a) * (1.0f - fx) + at(ty.b, tx.b) * fx;
        const Colour c = top * (1.0f - fy) + low * fy;
        for (int b = 0; b < 3; ++b) out[b] = c[b];
        continue;
      }
      const float waa = valid_a[tx.a] ? (1.0f - fx) * (1.0f - fy) : 0.0f;
      const float wab = valid_a[tx.b] ? fx * (1.0f - fy) : 0.0f;
      const float wba = valid_b[tx.a] ? (1.0f - fx) * fy : 0.0f;
      const float wbb = valid_b[tx.b] ? fx * fy : 0.0f;
      const float sum = std::min(1.0f, waa + wab + wba + wbb);
      if (sum <= 0.0f) continue;
      const Colour c = at(ty.a, tx.a) * waa + at(ty.a, tx.b) * wab + at(ty.b, tx.a) * wba + at(ty.b, tx.b) * wbb;
      for (int b = 0; b < 3; ++b) out[b] = out[b] * (1.0f - sum) + c[b];
    }
  }
  return w.all_valid ? RasterCoverage::all : RasterCoverage::some;
}

namespace {
bool overlaps(const LonLatBounds& b, const TileBounds& t) {
  if (t.south_deg >= b.north_deg || t.north_deg <= b.south_deg) return false;
  for (const double shift : {-360.0, 0.0, 360.0})
    if (t.west_deg + shift < b.east_deg && t.east_deg + shift > b.west_deg) return true;
  return false;
}

}  // namespace

ImagerySampler::ImagerySampler(std::vector<std::shared_ptr<Raster>> imagery, const HeightSampler& ground)
    : ground_(ground) {
  if (!imagery.empty() && imagery.front()->info().wraps && ground_.default_data()) {
    const RasterInfo info = imagery.front()->info();
    const auto drop_sea = [this, info](RasterBlock& block, uint32_t reduction, uint32_t bx, uint32_t by) {
      const double step = std::ldexp(1.0, static_cast<int>(reduction));
      const double dx = (info.bounds.east_deg - info.bounds.west_deg) / info.width * step;
      const double dy = (info.bounds.north_deg - info.bounds.south_deg) / info.height * step;
      std::vector<double> lon(block.width), lat(block.height);
      for (size_t i = 0; i < lon.size(); ++i)
        lon[i] = info.bounds.west_deg + (bx * Raster::kBlockSize + static_cast<double>(i) + 0.5) * dx;
      for (size_t j = 0; j < lat.size(); ++j)
        lat[j] = info.bounds.north_deg - (by * Raster::kBlockSize + static_cast<double>(j) + 0.5) * dy;
      std::vector<float> land(lon.size() * lat.size());
      ground_.land_field_m(lat, lon, dy, land.data());
      for (size_t p = 0; p < land.size(); ++p)
        if (land[p] <= 0.0f) block.valid[p] = 0;
    };
    land_only_ = std::make_unique<BlockCache>(imagery.front(), 192u << 20, drop_sea);
  }
  for (auto& raster : imagery) layers_.push_back(std::make_unique<BlockCache>(std::move(raster)));
}

void ImagerySampler::colours(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                             float* rgbx) const {
  std::fill_n(rgbx, lat_deg.size() * lon_deg.size() * 4, kNoImagery);
  std::vector<float> bare;
  for (size_t l = 0; l < layers_.size(); ++l) {
    const BlockCache& raster = *layers_[l];
    const uint32_t k = raster.reduction_for(spacing_deg);
    if (l > 0 || !land_only_) {
      lay_over(raster, k, lat_deg, lon_deg, rgbx);
      continue;
    }
    // Mostly no sea is near and one look is enough; else from the coarsest land to the finest over the raster as it is.
    if (lay_over(*land_only_, k, lat_deg, lon_deg, rgbx) == RasterCoverage::all) continue;
    lay_over(raster, k, lat_deg, lon_deg, rgbx);
    for (uint32_t up = kFillReductions + 1; up-- > 0;) lay_over(*land_only_, k + up, lat_deg, lon_deg, rgbx);
  }
}

double ImagerySampler::finest_pixel_deg(const TileBounds& tile) const {
  double finest = std::numeric_limits<double>::infinity();
  for (const auto& layer : layers_)
    if (overlaps(layer->info().bounds, tile)) finest = std::min(finest, layer->pixel_deg());
  return finest;
}

uint64_t ImagerySampler::blocks_read() const {
  uint64_t n = land_only_ ? land_only_->blocks_read() : 0;
  for (const auto& layer : layers_) n += layer->blocks_read();
  return n;
}

}  // namespace nepho
