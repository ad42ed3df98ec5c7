#include "terrain/raster_window.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace nepho {

namespace {

/// One axis of a raster in units of reduced pixels: pixel i covers i..i+1, the last one ends at `length`, which is not
/// a whole number when 2^reduction does not divide the raster's size.
struct AxisShape {
  int64_t count = 1;
  double length = 1.0;
  bool wraps = false, clamp_low = false, clamp_high = false;
  double centre(int64_t i) const {
    if (i == count - 1) return (static_cast<double>(count - 1) + length) / 2.0;
    return static_cast<double>(i) + 0.5;
  }
};

struct RawTap {
  int64_t a, b;
  double f;
};

RawTap tap_at(const AxisShape& s, double u) {
  if (!s.wraps && !s.clamp_low && u < -0.5) return {RasterAxis::kOutside, RasterAxis::kOutside, 0.0};
  if (!s.wraps && !s.clamp_high && u > s.length + 0.5) return {RasterAxis::kOutside, RasterAxis::kOutside, 0.0};
  auto i = static_cast<int64_t>(std::floor(u - 0.5));
  i = std::clamp<int64_t>(i, -1, s.count - 1);
  if (i == s.count - 2 && u >= s.centre(s.count - 1)) i = s.count - 1;
  RawTap t{i, i + 1, 0.0};
  double ca = 0.0, cb = 0.0;
  if (i < 0) {
    t.a = s.wraps ? s.count - 1 : (s.clamp_low ? 0 : RasterAxis::kOutside);
    ca = s.wraps ? s.centre(s.count - 1) - s.length : -0.5;
  } else {
    ca = s.centre(i);
  }
  if (i == s.count - 1) {
    t.b = s.wraps ? 0 : (s.clamp_high ? s.count - 1 : RasterAxis::kOutside);
    cb = s.length + 0.5;
  } else {
    cb = s.centre(i + 1);
  }
  t.f = std::clamp((u - ca) / (cb - ca), 0.0, 1.0);
  if (t.f == 0.0) t.b = t.a;  // a pixel of no weight does not count, valid or not
  if (t.f == 1.0) t.a = t.b;
  return t;
}

RasterAxis make_axis(const AxisShape& shape, std::span<const double> places) {
  RasterAxis axis;
  axis.taps.reserve(places.size());
  axis.pixels.reserve(places.size() + 2);
  const auto index_of = [&](int64_t pixel) {
    const size_t n = axis.pixels.size();
    for (size_t back = 1; back <= 2 && back <= n; ++back)
      if (axis.pixels[n - back] == pixel) return static_cast<uint32_t>(n - back);
    axis.pixels.push_back(pixel);
    if (pixel != RasterAxis::kOutside) axis.any_inside = true;
    return static_cast<uint32_t>(n);
  };
  for (const double u : places) {
    const RawTap t = tap_at(shape, u);
    const uint32_t a = index_of(t.a);
    axis.taps.push_back({a, index_of(t.b), t.f});
  }
  return axis;
}

}  // namespace

RasterAxis columns_at(const BlockCache& raster, uint32_t reduction, std::span<const double> lon_deg) {
  const RasterInfo& info = raster.info();
  const double step = std::ldexp(1.0, static_cast<int>(reduction));
  AxisShape shape;
  shape.count = raster.width_at(reduction);
  shape.length = info.width / step;
  shape.wraps = info.wraps;
  const double pixels_per_deg = info.width / (info.bounds.east_deg - info.bounds.west_deg);
  const double margin_deg = step / pixels_per_deg;
  std::vector<double> places(lon_deg.size());
  for (size_t i = 0; i < places.size(); ++i) {
    double d = lon_deg[i] - info.bounds.west_deg;
    d -= 360.0 * std::floor(d / 360.0);
    if (!info.wraps && d > 360.0 - margin_deg) d -= 360.0;  // just west of the raster
    places[i] = d * pixels_per_deg / step;
  }
  return make_axis(shape, places);
}

RasterAxis rows_at(const BlockCache& raster, uint32_t reduction, std::span<const double> lat_deg) {
  const RasterInfo& info = raster.info();
  const double step = std::ldexp(1.0, static_cast<int>(reduction));
  const double pixels_per_deg = info.height / (info.bounds.north_deg - info.bounds.south_deg);
  AxisShape shape;
  shape.count = raster.height_at(reduction);
  shape.length = info.height / step;
  shape.clamp_low = info.bounds.north_deg >= 90.0 - 1.0 / pixels_per_deg;
  shape.clamp_high = info.bounds.south_deg <= -90.0 + 1.0 / pixels_per_deg;
  std::vector<double> places(lat_deg.size());
  for (size_t i = 0; i < places.size(); ++i) places[i] = (info.bounds.north_deg - lat_deg[i]) * pixels_per_deg / step;
  return make_axis(shape, places);
}

bool overlaps(const LonLatBounds& raster, const TileBounds& tile) {
  if (tile.south_deg >= raster.north_deg || tile.north_deg <= raster.south_deg) return false;
  for (const double shift : {-360.0, 0.0, 360.0})
    if (tile.west_deg + shift < raster.east_deg && tile.east_deg + shift > raster.west_deg) return true;
  return false;
}

void gather(const BlockCache& raster, uint32_t reduction, const RasterAxis& x, const RasterAxis& y, RasterWindow& out) {
  const int64_t side = raster.side_at(reduction);
  out.columns = static_cast<uint32_t>(x.pixels.size());
  out.rows = static_cast<uint32_t>(y.pixels.size());
  out.bands = raster.info().bands;
  out.values.assign(size_t{out.columns} * out.rows * out.bands, 0.0f);
  out.valid.assign(size_t{out.columns} * out.rows, 0);
  out.all_valid = true;
  out.none_valid = true;
  struct Run {
    int64_t block;
    uint32_t first, last;  // [first, last) of the axis' pixels
  };
  const auto runs_of = [&](const std::vector<int64_t>& pixels) {
    std::vector<Run> runs;
    for (uint32_t i = 0; i < pixels.size(); ++i) {
      const int64_t block = pixels[i] == RasterAxis::kOutside ? -1 : pixels[i] / side;
      if (runs.empty() || runs.back().block != block)
        runs.push_back({block, i, i + 1});
      else
        runs.back().last = i + 1;
    }
    return runs;
  };
  const std::vector<Run> runs_x = runs_of(x.pixels), runs_y = runs_of(y.pixels);
  const size_t bands = out.bands;
  for (const Run& ry : runs_y)
    for (const Run& rx : runs_x) {
      if (ry.block < 0 || rx.block < 0) {
        out.all_valid = false;
        continue;
      }
      const auto block = raster.block(reduction, static_cast<uint32_t>(rx.block), static_cast<uint32_t>(ry.block));
      const RasterBlock& data = block->data;
      for (uint32_t j = ry.first; j < ry.last; ++j) {
        const size_t source_row = static_cast<size_t>(y.pixels[j] - ry.block * side) * data.width;
        const size_t target_row = size_t{j} * out.columns;
        for (uint32_t i = rx.first; i < rx.last; ++i) {
          const size_t from = source_row + static_cast<size_t>(x.pixels[i] - rx.block * side);
          const size_t to = target_row + i;
          const uint8_t valid = data.valid[from];
          out.valid[to] = valid;
          if (valid) {
            out.none_valid = false;
            if (bands == 1)
              out.values[to] = data.values[from];
            else
              std::memcpy(&out.values[to * bands], &data.values[from * bands], bands * sizeof(float));
          } else {
            out.all_valid = false;
          }
        }
      }
    }
}

}  // namespace nepho
