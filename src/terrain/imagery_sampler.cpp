#include "terrain/imagery_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "terrain/raster_window.h"

namespace nepho {

namespace {

constexpr float kNoImagery = 124.0f;  // sRGB of albedo 0.2

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

/// Centres of a block's pixels.
struct PixelCentres {
  std::vector<double> lat, lon;
};
PixelCentres centres_of(const RasterInfo& info, const RasterBlock& block, uint32_t reduction, uint32_t bx,
                        uint32_t by) {
  const double step = std::ldexp(1.0, static_cast<int>(reduction));
  const double dx = (info.bounds.east_deg - info.bounds.west_deg) / info.width * step;
  const double dy = (info.bounds.north_deg - info.bounds.south_deg) / info.height * step;
  PixelCentres c;
  for (uint32_t i = 0; i < block.width; ++i)
    c.lon.push_back(info.bounds.west_deg + (bx * Raster::kBlockSize + static_cast<double>(i) + 0.5) * dx);
  for (uint32_t j = 0; j < block.height; ++j)
    c.lat.push_back(info.bounds.north_deg - (by * Raster::kBlockSize + static_cast<double>(j) + 0.5) * dy);
  return c;
}

/// A global picture whose sea is painted over with the colours of the land around.
class LandPicture final : public Raster {
 public:
  LandPicture(std::shared_ptr<Raster> picture, const HeightSampler& ground)
      : info_(picture->info()),
        land_only_(std::move(picture), BlockCache::kBudgetBytes,
                   [this, &ground](RasterBlock& block, uint32_t k, uint32_t bx, uint32_t by) {
                     // A texel counts as land when its neighbours are land too: pictures bleed over their coasts.
                     const PixelCentres c = centres_of(info_, block, k, bx, by);
                     const double spacing = c.lat.size() > 1 ? c.lat[0] - c.lat[1] : 180.0;
                     std::vector<double> lat = {std::min(90.0, c.lat.front() + spacing)},
                                         lon = {c.lon.front() - spacing};
                     lat.insert(lat.end(), c.lat.begin(), c.lat.end());
                     lon.insert(lon.end(), c.lon.begin(), c.lon.end());
                     lat.push_back(std::max(-90.0, c.lat.back() - spacing));
                     lon.push_back(c.lon.back() + spacing);
                     std::vector<float> land(lat.size() * lon.size());
                     ground.land_field_m(lat, lon, spacing, land.data());
                     for (size_t y = 0; y < block.height; ++y)
                       for (size_t x = 0; x < block.width; ++x)
                         for (size_t n = 0; n < 9; ++n)
                           if (land[(y + n / 3) * lon.size() + x + n % 3] <= 0.0f) block.valid[y * block.width + x] = 0;
                   }) {
    while (std::max(land_only_.width_at(last_), land_only_.height_at(last_)) > 1) ++last_;
  }
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return last_ + 1; }
  const BlockCache& land_only() const { return land_only_; }
  void fill_from(const BlockCache& filled) { filled_ = &filled; }

  Result<RasterBlock> read_block(uint32_t k, uint32_t bx, uint32_t by) const override {
    RasterBlock block = land_only_.block(k, bx, by)->data;
    if (k >= last_ || std::all_of(block.valid.begin(), block.valid.end(), [](uint8_t v) { return v != 0; }))
      return block;
    const PixelCentres c = centres_of(info_, block, k, bx, by);
    std::vector<float> around(block.valid.size() * 4);
    lay_over(*filled_, k + 1, c.lat, c.lon, around.data());
    for (size_t p = 0; p < block.valid.size(); ++p) {
      if (block.valid[p]) continue;
      for (uint32_t b = 0; b < info_.bands; ++b) block.values[p * info_.bands + b] = around[p * 4 + std::min(b, 2u)];
      block.valid[p] = 1;
    }
    return block;
  }

 private:
  RasterInfo info_;
  BlockCache land_only_;
  uint32_t last_ = 0;
  const BlockCache* filled_ = nullptr;  // this picture's own blocks
};

}  // namespace

ImagerySampler::ImagerySampler(std::vector<std::shared_ptr<Raster>> imagery, const HeightSampler& ground) {
  for (auto& raster : imagery) {
    if (!layers_.empty() || !raster->info().wraps || !ground.default_data()) {
      layers_.push_back(std::make_unique<BlockCache>(std::move(raster)));
      continue;
    }
    auto land = std::make_shared<LandPicture>(std::move(raster), ground);
    layers_.push_back(std::make_unique<BlockCache>(land, BlockCache::kBudgetBytes, BlockCache::Filter{}, false));
    land->fill_from(*layers_.back());
  }
}

void ImagerySampler::colours(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                             float* rgbx) const {
  std::fill_n(rgbx, lat_deg.size() * lon_deg.size() * 4, kNoImagery);
  for (const auto& layer : layers_) lay_over(*layer, layer->reduction_for(spacing_deg), lat_deg, lon_deg, rgbx);
}

double ImagerySampler::finest_pixel_deg(const TileBounds& tile) const {
  double finest = std::numeric_limits<double>::infinity();
  for (const auto& layer : layers_)
    if (overlaps(layer->info().bounds, tile)) finest = std::min(finest, layer->pixel_deg());
  return finest;
}

uint64_t ImagerySampler::blocks_read() const {
  uint64_t n = 0;
  for (const auto& layer : layers_) n += layer->blocks_read();
  return n;
}

}  // namespace nepho
