#include "terrain/imagery_sampler.h"

#include <algorithm>
#include <cmath>

#include "terrain/raster_window.h"
#include "terrain/white_seas.h"

namespace nepho {

namespace {

/// sRGB, 0..255, of a linear value 0..1 (IEC 61966-2-1).
float srgb_255(double linear) {
  const double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<float>(255.0 * v);
}

/// Four floats at once: a colour.
using Colour = float __attribute__((vector_size(16)));

// The fourth is alpha, 0..255.
Colour load(const float* p) { return Colour{p[0], p[1], p[2], 255.0f}; }
Colour load_rgba(const float* p) { return Colour{p[0], p[1], p[2], p[3]}; }
Colour load_grey(const float* p) { return Colour{p[0], p[0], p[0], 255.0f}; }

}  // namespace

float ice_field(const float* rgb, double lat_deg) {
  // The darkest ice of the Blue Marble, old and wet, has about 150 of 255 in red; its palest shoals 100. What is left
  // of colour: a fifth of the brightest band.
  constexpr float kDarkest = 140.0f, kMostSaturation = 0.2f, kRampDegrees = 5.0f;
  const auto [low, high] = std::minmax({rgb[0], rgb[1], rgb[2]});
  const auto beyond = static_cast<float>(std::abs(lat_deg) - kLeastIceLatitude_deg);
  const float darkest = kDarkest + (256.0f - kDarkest) * std::clamp(1.0f - beyond / kRampDegrees, 0.0f, 1.0f);
  return std::min(low - darkest, kMostSaturation * high - (high - low));
}

float shore_field(const float* rgb) {
  // Deep sea in Landsat's colours is about 10 20 60, with noise of some levels; shoals on a bank 60 150 190.
  constexpr float kBrightest = 85.0f, kNoise = 4.0f;
  return std::max(std::max({rgb[0], rgb[1], rgb[2]}) - kBrightest, 2.0f * (std::max(rgb[0], rgb[1]) - rgb[2] - kNoise));
}

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
    return bands == 4 ? load_rgba(p) : bands >= 3 ? load(p) : load_grey(p);
  };
  bool opaque = true;
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
        if (c[3] >= 254.99f) {  // of four opaque texels, but for rounding
          for (int b = 0; b < 3; ++b) out[b] = c[b];
          continue;
        }
      }
      const float waa = valid_a[tx.a] ? (1.0f - fx) * (1.0f - fy) : 0.0f;
      const float wab = valid_a[tx.b] ? fx * (1.0f - fy) : 0.0f;
      const float wba = valid_b[tx.a] ? (1.0f - fx) * fy : 0.0f;
      const float wbb = valid_b[tx.b] ? fx * fy : 0.0f;
      // A texel counts by its alpha.
      const auto weighted = [](Colour c, float weight) { return c * (weight * c[3] / 255.0f); };
      const auto share = [](Colour c, float weight) { return weight * c[3] / 255.0f; };
      const Colour caa = at(ty.a, tx.a), cab = at(ty.a, tx.b), cba = at(ty.b, tx.a), cbb = at(ty.b, tx.b);
      const float sum = std::min(1.0f, share(caa, waa) + share(cab, wab) + share(cba, wba) + share(cbb, wbb));
      opaque = opaque && sum >= 1.0f;
      if (sum <= 0.0f) continue;
      const Colour c = weighted(caa, waa) + weighted(cab, wab) + weighted(cba, wba) + weighted(cbb, wbb);
      for (int b = 0; b < 3; ++b) out[b] = out[b] * (1.0f - sum) + c[b];
    }
  }
  return w.all_valid && opaque ? RasterCoverage::all : RasterCoverage::some;
}

namespace {

bool contains(const RasterInfo& info, const TileBounds& t) {
  const LonLatBounds& b = info.bounds;
  if (t.south_deg < b.south_deg || t.north_deg > b.north_deg) return false;
  for (const double shift : {-360.0, 0.0, 360.0})
    if (t.west_deg + shift >= b.west_deg && t.east_deg + shift <= b.east_deg) return true;
  return info.wraps;
}

/// Marks a block's texels that are not surely land: those on water of `ground` or next to it, as pictures bleed over
/// their coasts. Ice counts as land.
std::vector<uint8_t> land_of(const RasterInfo& info, const HeightSampler& ground, const RasterBlock& block,
                             uint32_t reduction, uint32_t bx, uint32_t by) {
  const double step = std::ldexp(1.0, static_cast<int>(reduction));
  const double dx = (info.bounds.east_deg - info.bounds.west_deg) / info.width * step;
  const double dy = (info.bounds.north_deg - info.bounds.south_deg) / info.height * step;
  const double west = info.bounds.west_deg + bx * Raster::kBlockSize * dx;
  const double north = info.bounds.north_deg - by * Raster::kBlockSize * dy;
  // One texel more on each side.
  std::vector<double> lat(block.height + 2), lon(block.width + 2);
  for (size_t i = 0; i < lon.size(); ++i) lon[i] = west + (static_cast<double>(i) - 0.5) * dx;
  for (size_t j = 0; j < lat.size(); ++j) lat[j] = std::clamp(north - (static_cast<double>(j) - 0.5) * dy, -90.0, 90.0);
  std::vector<float> field(lat.size() * lon.size());
  ground.land_field_m(lat, lon, std::max(dx, dy), field.data());
  std::vector<uint8_t> land = block.valid;
  for (size_t y = 0; y < block.height; ++y)
    for (size_t x = 0; x < block.width; ++x)
      for (size_t n = 0; n < 9; ++n)
        if (field[(y + n / 3) * lon.size() + x + n % 3] <= 0.0f) land[y * block.width + x] = 0;
  if (info.bands < 3) return land;
  for (size_t y = 0; y < block.height; ++y) {
    if (std::abs(lat[y + 1]) < kLeastIceLatitude_deg) continue;
    for (size_t p = y * block.width; p < (y + 1) * block.width; ++p)
      if (block.valid[p] && ice_field(&block.values[p * info.bands], lat[y + 1]) > 0.0f) land[p] = 1;
  }
  return land;
}

/// Gives every texel outside `land` the mean colour of the land texels around: averages upwards to coarser and coarser
/// texels, then interpolates downwards ("push-pull"). A block without land stays as it is.
void spread_land(RasterBlock& block, std::vector<uint8_t> land, uint32_t bands) {
  if (std::find(land.begin(), land.end(), uint8_t{1}) == land.end()) return;
  struct Level {
    uint32_t width, height;
    std::vector<float> values;
    std::vector<uint8_t> valid;
  };
  std::vector<Level> levels = {{block.width, block.height, block.values, std::move(land)}};
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Level& from = levels.back();
    Level to{(from.width + 1) / 2, (from.height + 1) / 2, {}, {}};
    to.values.resize(size_t{to.width} * to.height * bands);
    to.valid.resize(size_t{to.width} * to.height);
    for (uint32_t y = 0; y < to.height; ++y)
      for (uint32_t x = 0; x < to.width; ++x) {
        float* sum = &to.values[(size_t{y} * to.width + x) * bands];
        float count = 0.0f;
        for (uint32_t j = 2 * y; j < std::min(2 * y + 2, from.height); ++j)
          for (uint32_t i = 2 * x; i < std::min(2 * x + 2, from.width); ++i) {
            const size_t p = size_t{j} * from.width + i;
            if (!from.valid[p]) continue;
            count += 1.0f;
            for (uint32_t b = 0; b < bands; ++b) sum[b] += from.values[p * bands + b];
          }
        if (count == 0.0f) continue;
        to.valid[size_t{y} * to.width + x] = 1;
        for (uint32_t b = 0; b < bands; ++b) sum[b] /= count;
      }
    levels.push_back(std::move(to));
  }
  for (size_t l = levels.size() - 1; l-- > 0;) {
    Level& to = levels[l];
    const Level& from = levels[l + 1];
    for (uint32_t y = 0; y < to.height; ++y)
      for (uint32_t x = 0; x < to.width; ++x) {
        const size_t p = size_t{y} * to.width + x;
        if (to.valid[p]) continue;
        // The four coarser texels around, 9:3:3:1.
        const uint32_t x0 = x / 2, y0 = y / 2;
        const uint32_t x1 = std::min(x % 2 ? x0 + 1 : std::max(x0, 1u) - 1, from.width - 1);
        const uint32_t y1 = std::min(y % 2 ? y0 + 1 : std::max(y0, 1u) - 1, from.height - 1);
        for (uint32_t b = 0; b < bands; ++b) {
          const auto at = [&](uint32_t i, uint32_t j) { return from.values[(size_t{j} * from.width + i) * bands + b]; };
          to.values[p * bands + b] = (9.0f * at(x0, y0) + 3.0f * at(x1, y0) + 3.0f * at(x0, y1) + at(x1, y1)) / 16.0f;
        }
      }
  }
  block.values = std::move(levels[0].values);
}

}  // namespace

ImagerySampler::ImagerySampler(std::vector<std::shared_ptr<Raster>> imagery, const HeightSampler& ground,
                               double bare_albedo, const RasterCaches& caches)
    : ground_(ground), bare_srgb_(srgb_255(bare_albedo)) {
  for (auto& raster : imagery) {
    raster = SourceReader::of(std::move(raster), caches.timeout_s);  // one, however many caches read it
    BlockCache::Filter filter;
    if (layers_.empty() && raster->info().wraps && ground.default_data()) {
      bottom_as_it_is_ = std::make_unique<BlockCache>(raster, caches);
      filter = [info = raster->info(), &ground](RasterBlock& block, uint32_t reduction, uint32_t bx, uint32_t by) {
        spread_land(block, land_of(info, ground, block, reduction, bx, by), info.bands);
      };
    }
    const LonLatBounds b = raster->info().bounds;
    layers_.push_back(std::make_unique<BlockCache>(std::move(raster), caches, std::move(filter)));
    if (4.0 * layers_.back()->pixel_deg() < ground.finest_pixel_deg({b.west_deg, b.south_deg, b.east_deg, b.north_deg}))
      fine_.push_back(layers_.back().get());
  }
}

void ImagerySampler::lay_all(const BlockCache* bottom, std::span<const double> lat_deg, std::span<const double> lon_deg,
                             double spacing_deg, float* rgbx, const std::vector<const BlockCache*>* but) const {
  for (const auto& layer : layers_) {
    if (but && std::find(but->begin(), but->end(), layer.get()) != but->end()) continue;
    const BlockCache& from = bottom && layer == layers_.front() ? *bottom : *layer;
    lay_over(from, from.reduction_for(spacing_deg), lat_deg, lon_deg, rgbx);
  }
}

const std::vector<const BlockCache*>& ImagerySampler::maps_on_paper() const {
  static const std::vector<const BlockCache*> none;
  if (const TileReads* reads = TileReads::current(); reads && reads->extent() == TileReads::Extent::nothing)
    return none;
  std::call_once(paper_asked_, [this] {
    const TileReads all(TileReads::Extent::everything);  // it is found once
    for (const auto& layer : layers_) {
      const bool painted = bottom_as_it_is_ && layer == layers_.front();  // the sea with the land's colours
      if (has_white_seas(painted ? *bottom_as_it_is_ : *layer, ground_)) paper_.push_back(layer.get());
    }
  });
  return paper_;
}

void ImagerySampler::colours(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                             float* rgbx) const {
  std::fill_n(rgbx, lat_deg.size() * lon_deg.size() * 4, bare_srgb_);
  lay_all(nullptr, lat_deg, lon_deg, spacing_deg, rgbx);
}

void ImagerySampler::over_water(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                                float* out) const {
  constexpr float kSurelyNone = -256.0f;
  const size_t columns = lon_deg.size(), count = lat_deg.size() * columns;
  std::fill_n(out, count, kSurelyNone);
  std::vector<float> rgbx;
  const auto may_be_ice = [](double lat) { return std::abs(lat) > kLeastIceLatitude_deg; };
  if (!layers_.empty() && std::any_of(lat_deg.begin(), lat_deg.end(), may_be_ice)) {
    rgbx.assign(count * 4, 0.0f);  // nothing is not ice, however bright bare ground is
    lay_all(bottom_as_it_is_.get(), lat_deg, lon_deg, spacing_deg, rgbx.data(), &maps_on_paper());
    for (size_t j = 0; j < lat_deg.size(); ++j)
      for (size_t i = 0; i < columns && may_be_ice(lat_deg[j]); ++i)
        out[j * columns + i] = ice_field(&rgbx[(j * columns + i) * 4], lat_deg[j]);
  }
  // A dark shoal is as dark as the sea, give or take the noise of a pixel: what decides is the mean over some pixels,
  // or what is far from doubtful.
  constexpr double kMeanOver = 4.0;
  constexpr float kDoubtful = 40.0f;
  std::vector<float> mean;
  for (const BlockCache* layer : fine_) {
    // So dark that every place which the picture does not cover wholly stays darker than any picture.
    rgbx.assign(count * 4, -1e5f);
    mean.assign(count * 4, -1e5f);
    lay_over(*layer, layer->reduction_for(spacing_deg), lat_deg, lon_deg, rgbx.data());
    const double coarse_deg = kMeanOver * std::max(spacing_deg, layer->pixel_deg() * layer->info().oversampling);
    lay_over(*layer, layer->reduction_for(coarse_deg), lat_deg, lon_deg, mean.data());
    for (size_t p = 0; p < count; ++p) {
      if (rgbx[4 * p] <= -1.0f) continue;
      const float own = shore_field(&rgbx[4 * p]);
      out[p] = std::max({out[p], own - kDoubtful, mean[4 * p] > -1.0f ? shore_field(&mean[4 * p]) : own});
    }
  }
}

bool ImagerySampler::is_opaque(const BlockCache& layer) const {
  const std::lock_guard lock(opaque_mutex_);
  const auto known = opaque_.find(&layer);
  if (known != opaque_.end()) return known->second;
  bool opaque = !layer.whole_is_dear();
  if (const TileReads* reads = TileReads::current(); reads && reads->extent() == TileReads::Extent::nothing)
    return false;
  const uint32_t side = layer.side_at(0), bands = layer.info().bands;
  for (uint32_t y = 0; opaque && y * side < layer.info().height; ++y)
    for (uint32_t x = 0; opaque && x * side < layer.info().width; ++x) {
      const auto block = layer.block(0, x, y);
      opaque = block->all_valid;
      for (size_t p = 3; opaque && bands == 4 && p < block->data.values.size(); p += 4)
        opaque = block->data.values[p] >= 254.99f;
    }
  opaque_[&layer] = opaque;
  return opaque;
}

std::optional<PixelLattice> ImagerySampler::finest_lattice(const TileBounds& tile) const {
  const BlockCache* finest = nullptr;
  std::vector<const BlockCache*> covers;  // the whole tile
  for (size_t l = layers_.size(); l-- > 0;) {
    const BlockCache& layer = *layers_[l];
    if (!overlaps(layer.info().bounds, tile)) continue;
    if (!finest || layer.pixel_deg() < finest->pixel_deg()) {
      if (std::any_of(covers.begin(), covers.end(), [&](const BlockCache* c) { return is_opaque(*c); })) break;
      finest = &layer;
    }
    if (contains(layer.info(), tile)) covers.push_back(&layer);
  }
  if (!finest) return std::nullopt;
  const RasterInfo& info = finest->info();
  return PixelLattice{info.bounds.west_deg, info.bounds.north_deg,
                      (info.bounds.east_deg - info.bounds.west_deg) / info.width,
                      (info.bounds.north_deg - info.bounds.south_deg) / info.height, info.oversampling,
                      0.5 * (info.bounds.west_deg + info.bounds.east_deg)};
}

std::vector<SourceStats> ImagerySampler::source_stats() const {
  std::vector<SourceStats> all;
  for (const auto& layer : layers_) all.push_back(layer->stats());
  if (bottom_as_it_is_) all.front().from_disk += bottom_as_it_is_->stats().from_disk;
  return all;
}

uint64_t ImagerySampler::blocks_read() const {
  uint64_t n = 0;
  for (const auto& layer : layers_) n += layer->blocks_read();
  return n;
}

}  // namespace nepho
