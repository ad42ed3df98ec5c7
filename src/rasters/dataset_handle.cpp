#include "rasters/dataset_handle.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "io/raster_grid.h"
#include "rasters/pixel_delivery.h"

namespace nepho {

namespace {

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

}  // namespace

DatasetHandle::DatasetHandle(DatasetChain chain, const RasterLayout& layout)
    : chain_(std::move(chain)), layout_(layout) {
  find_levels();
}

void DatasetHandle::find_levels() {
  GDALDataset& dataset = *chain_.levels.front().dataset;
  const PixelGrid& grid = layout_.grid;
  Level full;
  for (const int band : layout_.plan.colors) full.colors.push_back(dataset.GetRasterBand(band));
  if (layout_.plan.alpha) full.alpha = dataset.GetRasterBand(layout_.plan.alpha);
  full.width = layout_.width;
  full.height = layout_.height;
  full.x_off = grid.x_off;
  full.y_off = grid.y_off;
  levels_.push_back(full);
  const uint32_t reductions = reduction_count(layout_.width, layout_.height);
  for (uint32_t k = 1; k < reductions; ++k) {
    if (k > layout_.finer_levels && k + layout_.averaged_reductions >= reductions) break;
    const auto warped = std::ranges::find(chain_.levels, k, &DatasetChain::Level::level);
    Level level;
    level.level = k;
    if (warped != chain_.levels.end()) {
      for (const int band : layout_.plan.colors) level.colors.push_back(warped->dataset->GetRasterBand(band));
      if (layout_.plan.alpha) level.alpha = warped->dataset->GetRasterBand(layout_.plan.alpha);
    } else {
      for (GDALRasterBand* band : full.colors) level.colors.push_back(matching_overview(*band, k));
      if (full.alpha) level.alpha = matching_overview(*full.alpha, k);
      if ((full.alpha && !level.alpha) || std::ranges::count(level.colors, nullptr) > 0) continue;
    }
    level.width = ceil_shift(layout_.width, k);
    level.height = ceil_shift(layout_.height, k);
    level.x_off = level_offset(grid.x_off, grid.width, grid.flip_x, k, level.width, level.colors[0]->GetXSize());
    level.y_off = level_offset(grid.y_off, grid.height, grid.flip_y, k, level.height, level.colors[0]->GetYSize());
    if (level.x_off >= 0 && level.y_off >= 0) levels_.push_back(level);
  }
}

const DatasetHandle::Level& DatasetHandle::level_for(uint32_t reduction) const {
  const Level* best = &levels_.front();
  for (const Level& level : levels_)
    if (level.level + (level.level > layout_.finer_levels ? layout_.averaged_reductions : 0) <= reduction)
      best = &level;
  return *best;
}

DatasetHandle::Window DatasetHandle::window_of(const Level& level, uint32_t x0, uint32_t y0, uint32_t width,
                                               uint32_t rows) const {
  return {level.x_off + static_cast<int>(layout_.grid.flip_x ? level.width - x0 - width : x0),
          level.y_off + static_cast<int>(layout_.grid.flip_y ? level.height - y0 - rows : y0)};
}

bool DatasetHandle::is_empty(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) const {
  // Without nodata or alpha what is empty reads as 0, which is a number like others.
  GDALRasterBand* const band = level.alpha ? level.alpha : level.colors[0];
  if (!level.alpha && !(band->GetMaskFlags() & GMF_NODATA)) return false;
  const Window at = window_of(level, x0, y0, width, rows);
  return band->GetDataCoverageStatus(at.x, at.y, static_cast<int>(width), static_cast<int>(rows), 0, nullptr) ==
         GDAL_DATA_COVERAGE_STATUS_EMPTY;
}

bool DatasetHandle::read_raw(const Level& level, uint32_t x0, uint32_t y0, uint32_t width, uint32_t rows) {
  const int w = static_cast<int>(width), h = static_cast<int>(rows);
  const auto [x, y] = window_of(level, x0, y0, width, rows);
  const size_t bands = level.colors.size() + (level.alpha ? 1 : 0), pixels = size_t{width} * rows;
  raw_.resize(pixels * bands);
  for (size_t b = 0; b < bands; ++b) {
    GDALRasterBand* band = b < level.colors.size() ? level.colors[b] : level.alpha;
    if (band->RasterIO(GF_Read, x, y, w, h, raw_.data() + b * pixels, w, h, GDT_Float32, 0, 0, nullptr) != CE_None)
      return false;
  }
  return read_mask(level, x, y, w, h);
}

bool DatasetHandle::read_mask(const Level& level, int x, int y, int width, int rows) {
  const size_t pixels = size_t(width) * size_t(rows);
  mask_.assign(pixels, uint8_t{1});
  if (level.alpha || !layout_.plan.palette.empty()) return true;  // alpha itself says what counts
  const int flags = level.colors[0]->GetMaskFlags();
  if (layout_.plan.weather && (flags & GMF_ALPHA)) return true;  // its opacity is cloud, not absence
  if (flags & GMF_PER_DATASET)
    return level.colors[0]->GetMaskBand()->RasterIO(GF_Read, x, y, width, rows, mask_.data(), width, rows, GDT_Byte, 0,
                                                    0, nullptr) == CE_None;
  for (GDALRasterBand* band : level.colors)
    if (!(band->GetMaskFlags() & GMF_NODATA)) return true;
  // Nodata is a matter of each band: a pixel counts unless all of its bands are void (black has a zero in each).
  std::fill(mask_.begin(), mask_.end(), uint8_t{0});
  for (size_t b = 0; b < level.colors.size(); ++b) {
    const double limit = std::numeric_limits<float>::max();
    const auto nodata = static_cast<float>(std::clamp(level.colors[b]->GetNoDataValue(), -limit, limit));
    const float* const raw = raw_.data() + b * pixels;
    for (size_t i = 0; i < pixels; ++i)
      if (raw[i] != nodata && !ARE_REAL_EQUAL(raw[i], nodata)) mask_[i] = 1;
  }
  return true;
}

void DatasetHandle::deliver(uint32_t row, uint32_t width, uint32_t rows, uint32_t bands, std::vector<float>& values,
                            std::vector<uint8_t>& valid) const {
  const size_t first = size_t{layout_.grid.flip_y ? rows - 1 - row : row} * width, count = size_t{width} * rows;
  deliver_row(layout_.plan, {raw_.data() + first, mask_.data() + first, count}, width, values.data(), valid.data());
  if (!layout_.grid.flip_x) return;
  std::reverse(valid.begin(), valid.end());
  for (uint32_t x = 0; x < width / 2; ++x)
    std::swap_ranges(values.begin() + std::ptrdiff_t(x) * bands, values.begin() + std::ptrdiff_t(x + 1) * bands,
                     values.begin() + std::ptrdiff_t(width - 1 - x) * bands);
}

}  // namespace nepho
