#include "weather/lonlat_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "geo/geodetic.h"

namespace nepho {

namespace {

constexpr uint8_t kHole = 0, kData = 1, kOutside = 2;
constexpr uint64_t kMostValues = 52'000'000;

uint32_t reduced(uint32_t size, uint32_t reduction) { return (size + (1u << reduction) - 1) >> reduction; }

}  // namespace

uint32_t LonLatGrid::reduction_for(const Raster& raster, double pixel_deg) {
  const RasterInfo& info = raster.info();
  const double step = std::max((info.bounds.east_deg - info.bounds.west_deg) / info.width,
                               (info.bounds.north_deg - info.bounds.south_deg) / info.height);
  const auto values = [&](uint32_t k) {
    return uint64_t{reduced(info.width, k)} * reduced(info.height, k) * info.bands;
  };
  uint32_t k = 0;
  while (k + 1 < raster.reductions() &&
         (std::ldexp(step, static_cast<int>(k) + 1) <= pixel_deg || values(k) > kMostValues))
    ++k;
  return k;
}

LonLatGrid::LonLatGrid(const Raster& raster, uint32_t reduction, const std::function<void(RasterBlock&)>& change) {
  const RasterInfo& info = raster.info();
  width_ = reduced(info.width, reduction);
  height_ = reduced(info.height, reduction);
  channels_ = info.bands;
  NEPHO_ASSERT_OP(channels_, <=, 4u);
  const double factor = std::ldexp(1.0, static_cast<int>(reduction));
  span_columns_ = info.width / factor;
  span_rows_ = info.height / factor;
  west_deg_ = info.bounds.west_deg;
  north_deg_ = info.bounds.north_deg;
  lon_step_deg_ = (info.bounds.east_deg - info.bounds.west_deg) / span_columns_;
  lat_step_deg_ = (info.bounds.north_deg - info.bounds.south_deg) / span_rows_;
  wraps_ = info.wraps;
  const double slack = 0.51 * lat_step_deg_ / factor;
  reaches_north_ = wraps_ && north_deg_ > 90.0 - slack;
  reaches_south_ = wraps_ && info.bounds.south_deg < -90.0 + slack;

  // A row on the pole itself is a small disc rather than a point.
  const double least = std::sin(rad_from_deg(lat_step_deg_ / 8.0));
  for (uint32_t row = 0; row < height_; ++row)
    cos_lat_.push_back(std::max(std::cos(rad_from_deg(row_lat_deg(row))), least));
  values_.resize(size_t{width_} * height_ * channels_);
  state_.resize(size_t{width_} * height_);
  constexpr uint32_t kSide = Raster::kBlockSize;
  for (uint32_t y0 = 0; y0 < height_; y0 += kSide)
    for (uint32_t x0 = 0; x0 < width_; x0 += kSide) {
      RasterBlock block = raster.read_block(reduction, x0 / kSide, y0 / kSide).take_or_throw(ErrorKind::input);
      if (change) change(block);
      for (uint32_t y = 0; y < block.height; ++y) {
        const size_t from = size_t{y} * block.width, to = size_t{y0 + y} * width_ + x0;
        std::copy_n(block.values.begin() + static_cast<std::ptrdiff_t>(from * channels_), block.width * channels_,
                    values_.begin() + static_cast<std::ptrdiff_t>(to * channels_));
        for (uint32_t x = 0; x < block.width; ++x) state_[to + x] = block.valid[from + x] ? kData : kHole;
      }
    }
}

/// Where pixel i has its centre, in pixels; the last one may be cut by the raster's edge.
double LonLatGrid::centre_of(uint32_t i, uint32_t count, double span) {
  return i + 1 < count ? i + 0.5 : 0.5 * (i + span);
}

LonLatGrid::Gaps LonLatGrid::separate_outside() {
  std::vector<uint32_t> front;
  const auto reach = [&](uint32_t x, uint32_t y) {
    const size_t i = size_t{y} * width_ + x;
    if (state_[i] != kHole) return;
    state_[i] = kOutside;
    front.push_back(static_cast<uint32_t>(i));
  };
  for (uint32_t x = 0; x < width_; ++x) {
    if (!reaches_north_) reach(x, 0);
    if (!reaches_south_) reach(x, height_ - 1);
  }
  for (uint32_t y = 0; y < height_ && !wraps_; ++y) {
    reach(0, y);
    reach(width_ - 1, y);
  }
  while (!front.empty()) {
    const uint32_t i = front.back(), x = i % width_, y = i / width_;
    front.pop_back();
    if (y > 0) reach(x, y - 1);
    if (y + 1 < height_) reach(x, y + 1);
    if (x > 0 || wraps_) reach(x > 0 ? x - 1 : width_ - 1, y);
    if (x + 1 < width_ || wraps_) reach(x + 1 < width_ ? x + 1 : 0, y);
  }
  size_t holes = 0, data = 0;
  for (const uint8_t s : state_) {
    holes += s == kHole;
    data += s == kData;
  }
  return {.holes = holes == 0 ? 0.0 : static_cast<double>(holes) / static_cast<double>(holes + data),
          .any_data = data > 0};
}

void LonLatGrid::fill_holes() {
  struct Level {
    uint32_t width, height;
    std::vector<float> sums, weights;
  };
  if (std::find(state_.begin(), state_.end(), kHole) == state_.end()) return;
  const auto weight_at = [&](size_t i) { return state_[i] == kData ? 1.0f : 0.0f; };
  std::vector<Level> levels;
  // Push: means of those that have data, over squares of 2, 4, 8, ... pixels.
  for (uint32_t w = width_, h = height_; w > 1 || h > 1;) {
    const uint32_t nw = (w + 1) / 2, nh = (h + 1) / 2;
    Level next{nw, nh, std::vector<float>(size_t{nw} * nh * channels_, 0.0f),
               std::vector<float>(size_t{nw} * nh, 0.0f)};
    const Level* from = levels.empty() ? nullptr : &levels.back();
    for (uint32_t y = 0; y < h; ++y)
      for (uint32_t x = 0; x < w; ++x) {
        const size_t i = size_t{y} * w + x, to = size_t{y / 2} * nw + x / 2;
        // A square with any data counts almost fully: its mean stands for it.
        const float weight = from ? std::min(from->weights[i], 1.0f) : weight_at(i);
        if (weight <= 0.0f) continue;
        next.weights[to] += weight;
        for (uint32_t c = 0; c < channels_; ++c)
          next.sums[to * channels_ + c] +=
              from ? from->sums[i * channels_ + c] / from->weights[i] * weight : values_[i * channels_ + c];
      }
    levels.push_back(std::move(next));
    w = nw;
    h = nh;
  }
  // Pull: what has no data takes the bilinear mean of the squares twice as large.
  for (size_t l = levels.size(); l-- > 0;) {
    const Level& coarse = levels[l];
    Level* fine = l > 0 ? &levels[l - 1] : nullptr;
    const uint32_t w = fine ? fine->width : width_, h = fine ? fine->height : height_;
    for (uint32_t y = 0; y < h; ++y)
      for (uint32_t x = 0; x < w; ++x) {
        const size_t i = size_t{y} * w + x;
        if (fine ? fine->weights[i] > 0.0f : state_[i] != kHole) continue;
        const int64_t nx = int64_t{x / 2} + (x % 2 ? 1 : -1), ny = int64_t{y / 2} + (y % 2 ? 1 : -1);
        const auto cw = static_cast<int64_t>(coarse.width), ch = static_cast<int64_t>(coarse.height);
        const size_t xs[] = {x / 2, static_cast<size_t>(wraps_ ? (nx + cw) % cw : std::clamp<int64_t>(nx, 0, cw - 1))};
        const size_t ys[] = {y / 2, static_cast<size_t>(std::clamp<int64_t>(ny, 0, ch - 1))};
        std::array<float, 4> sum{};
        float weight = 0.0f;
        for (int a = 0; a < 2; ++a)
          for (int b = 0; b < 2; ++b) {
            const size_t from = ys[a] * coarse.width + xs[b];
            if (coarse.weights[from] <= 0.0f) continue;
            const float share = (a ? 0.25f : 0.75f) * (b ? 0.25f : 0.75f);
            weight += share;
            for (uint32_t c = 0; c < channels_; ++c)
              sum[c] += share * coarse.sums[from * channels_ + c] / coarse.weights[from];
          }
        if (weight <= 0.0f) continue;
        for (uint32_t c = 0; c < channels_; ++c) (fine ? fine->sums : values_)[i * channels_ + c] = sum[c] / weight;
        if (fine)
          fine->weights[i] = 1.0f;
        else
          state_[i] = kData;
      }
  }
}

void LonLatGrid::soften_edges(double width_deg) {
  if (global() && std::find(state_.begin(), state_.end(), kOutside) == state_.end()) return;
  // Two box means of half the width make a tent; what is outside, and beyond the raster, counts 0.
  std::vector<float> inside(state_.size());
  for (size_t i = 0; i < state_.size(); ++i) inside[i] = state_[i] == kOutside ? 0.0f : 1.0f;
  const auto box = [](std::vector<float>& line, size_t radius, bool wraps, float beyond_first, float beyond_last) {
    const auto n = static_cast<int64_t>(line.size()), r = static_cast<int64_t>(std::min(radius, (line.size() - 1) / 2));
    const auto at = [&](int64_t i) {
      if (i >= 0 && i < n) return line[static_cast<size_t>(i)];
      if (wraps) return line[static_cast<size_t>((i + n) % n)];
      return i < 0 ? beyond_first : beyond_last;
    };
    std::vector<float> out(line.size());
    double sum = 0.0;
    for (int64_t i = -r; i <= r; ++i) sum += static_cast<double>(at(i));
    for (int64_t i = 0; i < n; ++i) {
      out[static_cast<size_t>(i)] = static_cast<float>(sum / static_cast<double>(2 * r + 1));
      sum += static_cast<double>(at(i + r + 1)) - static_cast<double>(at(i - r));
    }
    line = std::move(out);
  };
  const auto rows_wide = static_cast<size_t>(0.5 * width_deg / lat_step_deg_ + 0.5);
  std::vector<float> line;
  for (uint32_t x = 0; x < width_; ++x) {
    line.resize(height_);
    for (uint32_t y = 0; y < height_; ++y) line[y] = inside[size_t{y} * width_ + x];
    for (int pass = 0; pass < 2; ++pass)
      box(line, rows_wide, false, reaches_north_ ? 1.0f : 0.0f, reaches_south_ ? 1.0f : 0.0f);
    for (uint32_t y = 0; y < height_; ++y) inside[size_t{y} * width_ + x] = line[y];
  }
  for (uint32_t y = 0; y < height_; ++y) {
    const double columns = 0.5 * width_deg / (lon_step_deg_ * std::max(0.05, cos_lat_[y]));
    line.assign(inside.begin() + std::ptrdiff_t(y) * width_, inside.begin() + std::ptrdiff_t(y + 1) * width_);
    for (int pass = 0; pass < 2; ++pass) box(line, static_cast<size_t>(columns + 0.5), wraps_, 0.0f, 0.0f);
    for (uint32_t x = 0; x < width_; ++x) {
      // An edge has half of its surroundings inside: from there to nearly all.
      const float t = std::clamp((line[x] - 0.5f) * 2.1f, 0.0f, 1.0f);
      const size_t i = size_t{y} * width_ + x;
      for (uint32_t c = 0; c < channels_; ++c) values_[i * channels_ + c] *= t * t * (3.0f - 2.0f * t);
    }
  }
}

void LonLatGrid::add_row(uint32_t row, double row_weight, double lon_deg, double half_deg, double* sums) const {
  const double around = 360.0 / lon_step_deg_;  // pixels
  double x = std::fmod(lon_deg - west_deg_ + 1440.0, 360.0) / lon_step_deg_;
  if (!wraps_ && x > 0.5 * (span_columns_ + around)) x -= around;  // just west of the raster
  const double half = std::clamp(half_deg / (lon_step_deg_ * cos_lat_[row]), 1.0, std::max(1.0, 0.5 * span_columns_));
  const auto count = static_cast<int64_t>(width_);
  // One column more than the tent reaches: the last one of a raster may have its centre elsewhere.
  const auto first = static_cast<int64_t>(std::ceil(x - half - 0.5)), last = static_cast<int64_t>(x + half + 0.5);
  int64_t column = first;
  double offset = 0.0;  // of the centres, by whole turns
  if (wraps_) {
    const double turns = std::floor(static_cast<double>(first) / static_cast<double>(count));
    column -= static_cast<int64_t>(turns) * count;
    offset = turns * around;
  }
  const double per_half = row_weight / half, last_centre = centre_of(width_ - 1, width_, span_columns_);
  const float* const values = &values_[size_t{row} * width_ * channels_];
  const uint8_t* const state = &state_[size_t{row} * width_];
  double data = 0.0, all = 0.0;
  for (int64_t c = first; c <= last; ++c, ++column) {
    if (wraps_ && column == count) {
      column = 0;
      offset += around;
    }
    const double centre = column == count - 1 ? last_centre : static_cast<double>(column) + 0.5;
    const double weight = row_weight - std::abs(centre + offset - x) * per_half;
    if (weight <= 0.0) continue;
    all += weight;
    if (column < 0 || column >= count || state[column] != kData) continue;
    data += weight;
    const float* const v = values + static_cast<size_t>(column) * channels_;
    for (uint32_t k = 0; k < channels_; ++k) sums[k] += weight * static_cast<double>(v[k]);
  }
  sums[4] += data;
  sums[5] += all;
}

/// Around a pole rows are circles: pixels count by their place in the plane that touches the sphere.
double LonLatGrid::sample_polar(double lat_deg, double lon_deg, double half_deg, float* out) const {
  const double half = rad_from_deg(std::max(half_deg, lat_step_deg_)), lat = rad_from_deg(lat_deg);
  double sums[4] = {}, weight_data = 0.0, weight_all = 0.0;
  std::vector<double> sin_lon(width_), cos_lon(width_);
  for (uint32_t x = 0; x < width_; ++x) {
    const double lon = rad_from_deg(west_deg_ + centre_of(x, width_, span_columns_) * lon_step_deg_ - lon_deg);
    sin_lon[x] = std::sin(lon);
    cos_lon[x] = std::cos(lon);
  }
  for (uint32_t row = 0; row < height_; ++row) {
    if (std::abs(std::abs(row_lat_deg(row)) - std::abs(lat_deg)) > 1.5 * deg_from_rad(half) &&
        90.0 - std::abs(row_lat_deg(row)) > 1.5 * deg_from_rad(half))
      continue;
    const double row_lat = rad_from_deg(row_lat_deg(row)), c = std::cos(row_lat), s = std::sin(row_lat);
    if (s * lat < 0.0) continue;
    for (uint32_t x = 0; x < width_; ++x) {
      const double east = c * sin_lon[x], north = s * std::cos(lat) - c * cos_lon[x] * std::sin(lat);
      const double weight = (1.0 - std::abs(east) / half) * (1.0 - std::abs(north) / half) * cos_lat_[row];
      if (std::abs(east) >= half || std::abs(north) >= half) continue;
      weight_all += weight;
      const size_t i = size_t{row} * width_ + x;
      if (state_[i] != kData) continue;
      weight_data += weight;
      for (uint32_t k = 0; k < channels_; ++k) sums[k] += weight * static_cast<double>(values_[i * channels_ + k]);
    }
  }
  for (uint32_t k = 0; k < channels_; ++k)
    out[k] = weight_data > 0.0 ? static_cast<float>(sums[k] / weight_data) : 0.0f;
  return weight_all > 0.0 ? weight_data / weight_all : 0.0;
}

/// No pixel is near enough to count: most places of a regional raster.
bool LonLatGrid::beyond_reach(double lat_deg, double lon_deg, double half_deg) const {
  const double margin = std::max(half_deg, lat_step_deg_) + lat_step_deg_;
  if (lat_deg > north_deg_ + margin || lat_deg < north_deg_ - span_rows_ * lat_step_deg_ - margin) return true;
  if (wraps_) return false;
  const double reach =
      std::max(half_deg, lon_step_deg_) / std::max(0.02, std::cos(rad_from_deg(lat_deg))) + lon_step_deg_;
  const double east = std::fmod(lon_deg - west_deg_ + 1440.0, 360.0);
  return east > span_columns_ * lon_step_deg_ + reach && east < 360.0 - reach;
}

double LonLatGrid::sample(double lat_deg, double lon_deg, double half_deg, float* out) const {
  if (beyond_reach(lat_deg, lon_deg, half_deg)) {
    std::fill_n(out, channels_, 0.0f);
    return 0.0;
  }
  if (90.0 - std::abs(lat_deg) < 8.0 * std::max(half_deg, lat_step_deg_) &&
      (lat_deg > 0.0 ? reaches_north_ : reaches_south_))
    return sample_polar(lat_deg, lon_deg, half_deg, out);
  const double y = (north_deg_ - lat_deg) / lat_step_deg_;
  const double half = std::max(1.0, half_deg / lat_step_deg_);
  double sums[6] = {};  // channels, weight with data, all weight
  double rows_inside = 0.0, rows_outside = 0.0;
  const auto first = static_cast<int64_t>(std::floor(y - half - 0.5)), last = static_cast<int64_t>(std::ceil(y + half));
  for (int64_t r = first; r <= last; ++r) {
    const bool beyond = r < 0 || r >= static_cast<int64_t>(height_);
    const double centre =
        beyond ? static_cast<double>(r) + 0.5 : centre_of(static_cast<uint32_t>(r), height_, span_rows_);
    const double weight = 1.0 - std::abs(centre - y) / half;
    if (weight <= 0.0) continue;
    (beyond ? rows_outside : rows_inside) += weight;
    if (!beyond) add_row(static_cast<uint32_t>(r), weight, lon_deg, half_deg, sums);
  }
  for (uint32_t c = 0; c < channels_; ++c) out[c] = sums[4] > 0.0 ? static_cast<float>(sums[c] / sums[4]) : 0.0f;
  if (sums[5] <= 0.0) return 0.0;
  return sums[4] / sums[5] * rows_inside / (rows_inside + rows_outside);
}

}  // namespace nepho
