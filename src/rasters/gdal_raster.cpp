#include "rasters/gdal_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "io/raster_grid.h"

namespace nepho {

namespace {

/// Voids that a file does not declare are no heights: the one of 16-bit elevation, and what no place on Earth reaches.
constexpr float kVoid = -32768.0f;
constexpr float kLargestHeight_m = 20000.0f;

/// A pyramid of a file may have been made by picking pixels rather than averaging: each delivered pixel averages at
/// least 8 x 8 of its pixels, which also bounds what a block costs.
constexpr uint32_t kAveragedReductions = 3;

constexpr size_t kScratchPixels = size_t{1} << 20;

uint32_t ceil_shift(uint32_t value, uint32_t bits) { return (value + (1u << bits) - 1) >> bits; }

/// The overview of `band` that is `band` halved `level` times to an eighth of its own pixel, and masked the same way.
GDALRasterBand* matching_overview(GDALRasterBand& band, uint32_t level) {
  for (int i = 0; i < band.GetOverviewCount(); ++i) {
    GDALRasterBand* overview = band.GetOverview(i);
    if (!overview) continue;
    const auto drift = [&](int reduced, int full) { return std::llabs((int64_t{reduced} << level) - full) * 8; };
    const int64_t pixel = int64_t{1} << level;
    if (drift(overview->GetXSize(), band.GetXSize()) <= pixel &&
        drift(overview->GetYSize(), band.GetYSize()) <= pixel && overview->GetMaskFlags() == band.GetMaskFlags())
      return overview;
  }
  return nullptr;
}

/// First dataset pixel of `delivered` pixels at a level, whose other end is the dataset's when the axis is flipped; -1
/// where the level's pixels straddle the delivered ones.
int level_offset(int offset, int size, bool flip, uint32_t level, uint32_t delivered, int available) {
  const int aligned_end = flip ? offset + size : offset;
  if (aligned_end % (1 << level) != 0) return -1;
  const int first = flip ? (aligned_end >> level) - static_cast<int>(delivered) : aligned_end >> level;
  return first >= 0 && first + static_cast<int>(delivered) <= available ? first : -1;
}

/// One row of raw numbers: band b of pixel x is raw[b * stride + x].
struct BandView {
  const float* raw;
  const uint8_t* mask;
  size_t stride;
};

void deliver_heights(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const float* const alpha = plan.alpha ? in.raw + in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x) {
    const float raw = in.raw[x], height_m = raw * scale + offset;
    // NaN fails the comparison of heights.
    const bool good =
        in.mask[x] && raw != kVoid && std::abs(height_m) < kLargestHeight_m && (!alpha || alpha[x] > 0.0f);
    valid[x] = good ? 1 : 0;
    out[x] = good ? height_m : 0.0f;
  }
}

void deliver_palette(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  for (uint32_t x = 0; x < width; ++x) {
    const auto entry = static_cast<size_t>(std::max(in.raw[x], 0.0f));
    const bool good = entry < plan.palette.size() && plan.palette[entry][3] > 0.0f;
    const std::array<float, 4> rgba = good ? plan.palette[entry] : std::array<float, 4>{};
    std::copy(rgba.begin(), rgba.end(), out + size_t{x} * 4);
    valid[x] = good ? 1 : 0;
  }
}

void deliver_colors(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const auto alpha_scale = static_cast<float>(255.0 / plan.alpha_max);
  const size_t g = plan.colors.size() == 3 ? in.stride : 0, b = 2 * g;
  const float* const alpha = plan.alpha ? in.raw + plan.colors.size() * in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x, out += 4) {
    const float* const raw = in.raw + x;
    const bool good = in.mask[x] && std::isfinite(raw[0] + raw[g] + raw[b]) && (!alpha || alpha[x] > 0.0f);
    valid[x] = good ? 1 : 0;
    out[0] = good ? std::clamp(raw[0] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[1] = good ? std::clamp(raw[g] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[2] = good ? std::clamp(raw[b] * scale + offset, 0.0f, 255.0f) : 0.0f;
    out[3] = !good ? 0.0f : alpha ? std::min(alpha[x] * alpha_scale, 255.0f) : 255.0f;
  }
}

void deliver_weather(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  constexpr float kSlack = 0.02f;  // packing and interpolation overshoot; anything further is no cover
  const auto scale = static_cast<float>(plan.scale), offset = static_cast<float>(plan.offset);
  const auto opacity_scale = static_cast<float>(plan.opacity_scale);
  const bool with_opacity = plan.opacity_scale > 0.0;
  const size_t values = plan.colors.size() - (with_opacity ? 1 : 0), bands = static_cast<size_t>(plan.weather);
  const float* const alpha = plan.alpha ? in.raw + plan.colors.size() * in.stride : nullptr;
  for (uint32_t x = 0; x < width; ++x, out += bands) {
    bool good = in.mask[x] && (!alpha || alpha[x] > 0.0f);
    for (size_t b = 0; b < values; ++b) {
      const float v = in.raw[b * in.stride + x] * scale + offset;
      good = good && v >= -kSlack && v <= 1.0f + kSlack;  // NaN fails
      const float opacity = with_opacity ? in.raw[values * in.stride + x] * opacity_scale : 1.0f;
      out[b] = std::clamp(v, 0.0f, 1.0f) * std::clamp(opacity, 0.0f, 1.0f);
    }
    for (size_t b = values; b < bands; ++b) out[b] = 0.0f;
    valid[x] = good ? 1 : 0;
    if (!good) std::fill_n(out, bands, 0.0f);
  }
}

void deliver_weather_palette(const BandPlan& plan, const BandView& in, uint32_t width, float* out, uint8_t* valid) {
  const auto bands = static_cast<size_t>(plan.weather);
  for (uint32_t x = 0; x < width; ++x, out += bands) {
    const auto entry = static_cast<size_t>(std::max(in.raw[x], 0.0f));
    const bool good = entry < plan.palette.size() && !std::isnan(plan.palette[entry][0]);
    for (size_t b = 0; b < bands; ++b) out[b] = good ? plan.palette[entry][b] : 0.0f;
    valid[x] = good ? 1 : 0;
  }
}

}  // namespace

GdalRaster::GdalRaster(RasterInfo info, std::vector<GDALDatasetUniquePtr> datasets, PixelGrid grid, BandPlan plan)
    : info_(std::move(info)), datasets_(std::move(datasets)), grid_(grid), plan_(std::move(plan)) {
  find_levels();
}

GdalRaster::~GdalRaster() {
  while (!datasets_.empty()) datasets_.pop_back();
}

uint32_t GdalRaster::reductions() const { return reduction_count(info_.width, info_.height); }

void GdalRaster::find_levels() {
  GDALDataset& dataset = *datasets_.back();
  Level full;
  for (const int band : plan_.colors) full.colors.push_back(dataset.GetRasterBand(band));
  if (plan_.alpha) full.alpha = dataset.GetRasterBand(plan_.alpha);
  full.width = info_.width;
  full.height = info_.height;
  full.x_off = grid_.x_off;
  full.y_off = grid_.y_off;
  levels_.push_back(full);
  for (uint32_t k = 1; k + kAveragedReductions < reductions(); ++k) {
    Level level;
    level.level = k;
    for (GDALRasterBand* band : full.colors) level.colors.push_back(matching_overview(*band, k));
    if (full.alpha) level.alpha = matching_overview(*full.alpha, k);
    if ((full.alpha && !level.alpha) || std::ranges::count(level.colors, nullptr) > 0) continue;
    level.width = ceil_shift(info_.width, k);
    level.height = ceil_shift(info_.height, k);
    level.x_off = level_offset(grid_.x_off, grid_.width, grid_.flip_x, k, level.width, level.colors[0]->GetXSize());
    level.y_off = level_offset(grid_.y_off, grid_.height, grid_.flip_y, k, level.height, level.colors[0]->GetYSize());
    if (level.x_off >= 0 && level.y_off >= 0) levels_.push_back(level);
  }
}

const GdalRaster::Level& GdalRaster::level_for(uint32_t reduction) const {
  const Level* best = &levels_.front();
  for (const Level& level : levels_)
    if (level.level + kAveragedReductions <= reduction) best = &level;
  return *best;
}

bool GdalRaster::read_raw(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) const {
  const int w = static_cast<int>(width), h = static_cast<int>(rows);
  const int x = level.x_off + static_cast<int>(grid_.flip_x ? level.width - x0 - width : x0);
  const int y = level.y_off + static_cast<int>(grid_.flip_y ? level.height - y0 - rows : y0);
  const size_t bands = level.colors.size() + (level.alpha ? 1 : 0), pixels = size_t{width} * rows;
  scratch_.raw.resize(pixels * bands);
  for (size_t b = 0; b < bands; ++b) {
    GDALRasterBand* band = b < level.colors.size() ? level.colors[b] : level.alpha;
    if (band->RasterIO(GF_Read, x, y, w, h, scratch_.raw.data() + b * pixels, w, h, GDT_Float32, 0, 0, nullptr) !=
        CE_None)
      return false;
  }
  return read_mask(level, x, y, w, h);
}

bool GdalRaster::read_mask(const Level& level, int x, int y, int width, int rows) const {
  const size_t pixels = size_t(width) * size_t(rows);
  scratch_.mask.assign(pixels, uint8_t{1});
  if (level.alpha || !plan_.palette.empty()) return true;  // alpha itself says what counts
  const int flags = level.colors[0]->GetMaskFlags();
  if (plan_.weather && (flags & GMF_ALPHA)) return true;  // its opacity is cloud, not absence
  if (flags & GMF_PER_DATASET)
    return level.colors[0]->GetMaskBand()->RasterIO(GF_Read, x, y, width, rows, scratch_.mask.data(), width, rows,
                                                    GDT_Byte, 0, 0, nullptr) == CE_None;
  for (GDALRasterBand* band : level.colors)
    if (!(band->GetMaskFlags() & GMF_NODATA)) return true;
  // Nodata is a matter of each band: a pixel counts unless all of its bands are void (black has a zero in each).
  std::fill(scratch_.mask.begin(), scratch_.mask.end(), uint8_t{0});
  for (size_t b = 0; b < level.colors.size(); ++b) {
    const double limit = std::numeric_limits<float>::max();
    const auto nodata = static_cast<float>(std::clamp(level.colors[b]->GetNoDataValue(), -limit, limit));
    const float* const raw = scratch_.raw.data() + b * pixels;
    for (size_t i = 0; i < pixels; ++i)
      if (raw[i] != nodata && !ARE_REAL_EQUAL(raw[i], nodata)) scratch_.mask[i] = 1;
  }
  return true;
}

void GdalRaster::deliver_row(uint32_t row, uint32_t width, uint32_t rows, std::vector<float>& values,
                             std::vector<uint8_t>& valid) const {
  const size_t first = size_t{grid_.flip_y ? rows - 1 - row : row} * width, count = size_t{width} * rows;
  const BandView bands{scratch_.raw.data() + first, scratch_.mask.data() + first, count};
  if (plan_.elevation)
    deliver_heights(plan_, bands, width, values.data(), valid.data());
  else if (plan_.weather)
    (plan_.palette.empty() ? deliver_weather : deliver_weather_palette)(plan_, bands, width, values.data(),
                                                                        valid.data());
  else if (!plan_.palette.empty())
    deliver_palette(plan_, bands, width, values.data(), valid.data());
  else
    deliver_colors(plan_, bands, width, values.data(), valid.data());
  if (!grid_.flip_x) return;
  std::reverse(valid.begin(), valid.end());
  for (uint32_t x = 0; x < width / 2; ++x)
    std::swap_ranges(values.begin() + std::ptrdiff_t(x) * info_.bands,
                     values.begin() + std::ptrdiff_t(x + 1) * info_.bands,
                     values.begin() + std::ptrdiff_t(width - 1 - x) * info_.bands);
}

Result<RasterBlock> GdalRaster::read_block(uint32_t reduction, uint32_t bx, uint32_t by) const {
  if (!block_window(info_, reduction, bx, by))
    return Result<RasterBlock>::failed(
        fmt::format("{}: has no block ({}, {}) at reduction {}", info_.path, bx, by, reduction));
  const Level& level = level_for(reduction);
  RasterInfo reduced = info_;
  reduced.width = level.width;
  reduced.height = level.height;
  const BlockWindow w = *block_window(reduced, reduction - level.level, bx, by);

  const std::lock_guard lock(mutex_);
  const GdalMessages messages;
  BlockAverager averager(w.src_width, w.src_height, info_.bands, w.factor);
  std::vector<float> values(size_t{w.src_width} * info_.bands);
  std::vector<uint8_t> valid(w.src_width);
  const auto strip = static_cast<uint32_t>(std::max<size_t>(1, kScratchPixels / w.src_width));
  for (uint32_t y = 0; y < w.src_height; y += strip) {
    const uint32_t rows = std::min(strip, w.src_height - y);
    if (!read_raw(level, w.x0, w.y0 + y, w.src_width, rows) || messages.contains("Premature end of JPEG"))
      return Result<RasterBlock>::failed(
          fmt::format("{}: is cut off or damaged, its pixels cannot be read{}", info_.path, messages.in_brackets()));
    for (uint32_t row = 0; row < rows; ++row) {
      deliver_row(row, w.src_width, rows, values, valid);
      averager.add_row(values, valid);
    }
  }
  return std::move(averager).finish();
}

}  // namespace nepho
