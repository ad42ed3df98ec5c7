// What is drawn where a raster of heights has none: in its voids, and around it.
#include <algorithm>
#include <cmath>

#include "geo/geodetic.h"
#include "terrain/height_layer.h"
#include "terrain/height_sampler.h"
#include "terrain/raster_window.h"

namespace nepho {

bool sample_layer(const BlockCache& raster, std::span<const double> lat_deg, std::span<const double> lon_deg,
                  uint32_t reduction, std::vector<double>& value, std::vector<float>& weight) {
  const RasterAxis x = columns_at(raster, reduction, lon_deg);
  if (!x.any_inside) return false;
  const RasterAxis y = rows_at(raster, reduction, lat_deg);
  if (!y.any_inside) return false;
  RasterWindow w;
  gather(raster, reduction, x, y, w);
  if (w.none_valid) return false;
  const size_t columns = lon_deg.size();
  value.resize(columns * lat_deg.size());
  weight.resize(value.size());
  for (size_t j = 0; j < lat_deg.size(); ++j) {
    const RasterAxis::Tap ty = y.taps[j];
    const float* row_a = &w.values[size_t{ty.a} * w.columns];
    const float* row_b = &w.values[size_t{ty.b} * w.columns];
    const uint8_t* valid_a = &w.valid[size_t{ty.a} * w.columns];
    const uint8_t* valid_b = &w.valid[size_t{ty.b} * w.columns];
    for (size_t i = 0; i < columns; ++i) {
      const RasterAxis::Tap tx = x.taps[i];
      const size_t out = j * columns + i;
      if (w.all_valid || (valid_a[tx.a] && valid_a[tx.b] && valid_b[tx.a] && valid_b[tx.b])) {
        const double top = static_cast<double>(row_a[tx.a]) * (1.0 - tx.f) + static_cast<double>(row_a[tx.b]) * tx.f;
        const double low = static_cast<double>(row_b[tx.a]) * (1.0 - tx.f) + static_cast<double>(row_b[tx.b]) * tx.f;
        value[out] = top * (1.0 - ty.f) + low * ty.f;
        weight[out] = 1.0f;
        continue;
      }
      const double waa = valid_a[tx.a] ? (1.0 - tx.f) * (1.0 - ty.f) : 0.0;
      const double wab = valid_a[tx.b] ? tx.f * (1.0 - ty.f) : 0.0;
      const double wba = valid_b[tx.a] ? (1.0 - tx.f) * ty.f : 0.0;
      const double wbb = valid_b[tx.b] ? tx.f * ty.f : 0.0;
      const double sum = waa + wab + wba + wbb;
      weight[out] = static_cast<float>(sum);
      value[out] = sum > 0.0 ? (waa * static_cast<double>(row_a[tx.a]) + wab * static_cast<double>(row_a[tx.b]) +
                                wba * static_cast<double>(row_b[tx.a]) + wbb * static_cast<double>(row_b[tx.b])) /
                                   sum
                             : 0.0;
    }
  }
  if (const auto opacity = static_cast<float>(raster.info().opacity); opacity < 1.0f)
    for (float& w_out : weight) w_out *= opacity;
  return true;
}

namespace {

/// Voids of up to some 2^this pixels across are filled by their rim.
constexpr uint32_t kVoidReductions = 6;

bool has_longitude(const LonLatBounds& b, double lon_deg) {
  return b.west_deg + std::fmod(lon_deg - b.west_deg + 720.0, 360.0) <= b.east_deg;
}

/// The default data are bent towards a raster's edge over this many of their pixels.
constexpr double kEdgePixels = 1.5;
/// Land lower than this above the sea, m, is bent the less the lower it is: coasts stay where they are.
constexpr double kCoast_m = 30.0;

/// How far the places of an axis are outside [low, high], degrees, and the nearest place inside.
struct Outside {
  std::vector<double> nearest, distance;
};

Outside outside(std::span<const double> places, double low, double high, bool longitudes, bool wraps) {
  Outside out{.nearest = {places.begin(), places.end()}, .distance = std::vector<double>(places.size(), 0.0)};
  if (wraps) return out;
  for (size_t i = 0; i < places.size(); ++i) {
    double v = places[i];
    if (longitudes) v = low + std::fmod(v - low + 720.0, 360.0);
    const double west_of = longitudes ? low + 360.0 - v : low - v, east_of = v - high;
    if (v >= low && v <= high) continue;
    const bool after = longitudes ? east_of < west_of : v > high;
    out.nearest[i] = after ? high : low;
    out.distance[i] = after ? east_of : west_of;
  }
  return out;
}

/// Whether a place within bounds is no farther than this from one of their sides, degrees along an axis.
bool near_edge(const LonLatBounds& b, double lat_deg, double lon_deg, double within_deg) {
  const double east_of_west = std::fmod(lon_deg - b.west_deg + 720.0, 360.0);
  return std::min({lat_deg - b.south_deg, b.north_deg - lat_deg, east_of_west,
                   b.east_deg - b.west_deg - east_of_west}) < within_deg;
}

LonLatBounds shrunk(LonLatBounds b, double by_deg, bool wraps) {
  b.south_deg += by_deg;
  b.north_deg -= by_deg;
  if (wraps) return b;
  b.west_deg += by_deg;
  b.east_deg -= by_deg;
  return b;
}

}  // namespace

bool overlaps_grid(const LonLatBounds& b, std::span<const double> lat_deg, std::span<const double> lon_deg) {
  return std::any_of(lat_deg.begin(), lat_deg.end(), [&](double v) { return v >= b.south_deg && v <= b.north_deg; }) &&
         std::any_of(lon_deg.begin(), lon_deg.end(), [&](double v) { return has_longitude(b, v); });
}

std::vector<double> HeightSampler::edge_lift(std::span<const double> lat_deg, std::span<const double> lon_deg,
                                             double spacing_deg, const double* undulation,
                                             std::span<const double> default_msl, size_t layers, bool inside) const {
  const BlockCache& below = *layers_.front();
  const double reach_deg = kEdgePixels * below.pixel_deg();
  const size_t columns = lon_deg.size(), count = columns * lat_deg.size();
  std::vector<double> sum, total, most, value, below_value;
  std::vector<float> share, below_share;
  for (size_t l = 1; l < std::min(layers, layers_.size()); ++l) {
    const BlockCache& raster = *layers_[l];
    const RasterInfo& info = raster.info();
    const uint32_t finest = raster.reduction_for(spacing_deg);
    const double px = std::ldexp(raster.pixel_deg(), static_cast<int>(finest));
    if (info.opacity < 1.0 || 4.0 * raster.pixel_deg() > below.pixel_deg() || px > reach_deg) continue;
    const LonLatBounds inner = shrunk(info.bounds, 0.5 * px, info.wraps);
    if (inner.west_deg >= inner.east_deg || inner.south_deg >= inner.north_deg) continue;
    const Outside y = outside(lat_deg, inner.south_deg, inner.north_deg, false, false);
    const Outside x = outside(lon_deg, inner.west_deg, inner.east_deg, true, info.wraps);
    struct Near {
      size_t place;
      double distance_deg, reduction, lift = 0.0;
    };
    std::vector<Near> near;
    double coarsest = finest;
    for (size_t j = 0; j < lat_deg.size(); ++j) {
      if (y.distance[j] >= reach_deg) continue;
      const double cos_lat = std::cos(rad_from_deg(y.nearest[j]));
      for (size_t i = 0; i < columns; ++i) {
        const double d = std::hypot(x.distance[i] * cos_lat, y.distance[j]);
        if (d >= reach_deg || (d <= 0.0 && !(inside && near_edge(inner, lat_deg[j], lon_deg[i], reach_deg)))) continue;
        // The farther from the edge, the smoother the edge that is carried on there.
        near.push_back({j * columns + i, d, finest + std::log2(1.0 + d / px)});
        coarsest = std::max(coarsest, near.back().reduction);
      }
    }
    if (near.empty()) continue;
    uint32_t last = finest;
    while (last < coarsest && std::min(raster.width_at(last + 1), raster.height_at(last + 1)) >= 2) ++last;
    const bool ellipsoidal = info.vertical == VerticalDatum::ellipsoid;
    for (uint32_t k = finest; k <= last; ++k) {
      const double px_k = std::ldexp(raster.pixel_deg(), static_cast<int>(k));
      const LonLatBounds b = shrunk(info.bounds, 0.5 * px_k, info.wraps);
      const std::vector<double> lat = outside(lat_deg, b.south_deg, b.north_deg, false, false).nearest;
      const std::vector<double> lon = outside(lon_deg, b.west_deg, b.east_deg, true, info.wraps).nearest;
      if (!sample_layer(raster, lat, lon, k, value, share) ||
          !sample_layer(below, lat, lon, below.reduction_for(px_k), below_value, below_share))
        continue;
      for (Near& n : near) {
        const double f = std::max(0.0, 1.0 - std::abs(std::min(n.reduction, static_cast<double>(last)) - k));
        if (f == 0.0 || below_share[n.place] <= 0.0f) continue;
        const double v = ellipsoidal && undulation ? value[n.place] - undulation[n.place] : value[n.place];
        n.lift += f * static_cast<double>(share[n.place]) * (v - below_value[n.place]);
      }
    }
    if (sum.empty()) {
      sum.assign(count, 0.0);
      total.assign(count, 0.0);
      most.assign(count, 0.0);
    }
    for (const Near& n : near) {
      const double t = n.distance_deg / reach_deg, fade = 1.0 - t * t * (3.0 - 2.0 * t);
      const double weight = fade / (1.0 - fade + 1e-9);  // on an edge that raster alone counts
      sum[n.place] += weight * n.lift;
      total[n.place] += weight;
      most[n.place] = std::max(most[n.place], fade);
    }
  }
  for (size_t i = 0; i < sum.size(); ++i)
    sum[i] = total[i] > 0.0 ? most[i] * std::clamp(default_msl[i] / kCoast_m, 0.0, 1.0) * sum[i] / total[i] : 0.0;
  return sum;
}

void HeightSampler::add_edge_lift(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                                  std::vector<double>& default_msl) const {
  if (layers_.size() < 2) return;
  std::vector<double> undulation;
  if (needs_undulation_) undulation = undulations_m(lat_deg, lon_deg);
  const std::vector<double> lift = edge_lift(
      lat_deg, lon_deg, spacing_deg, needs_undulation_ ? undulation.data() : nullptr, default_msl, layers(), true);
  for (size_t i = 0; i < lift.size(); ++i) default_msl[i] += lift[i];
}

void HeightSampler::fill_voids(size_t layer, std::span<const double> lat_deg, std::span<const double> lon_deg,
                               const double* undulation, uint32_t reduction, const std::vector<float>& weight,
                               Field& below) const {
  const BlockCache& raster = *layers_[layer];
  if (raster.info().opacity < 1.0) return;
  // The outer half pixel fades out everywhere: that is no void.
  const double half_px = 0.5 * std::ldexp(raster.pixel_deg(), static_cast<int>(reduction));
  LonLatBounds bounds = raster.info().bounds;
  bounds.south_deg += half_px;
  bounds.north_deg -= half_px;
  if (!raster.info().wraps) {
    bounds.west_deg += half_px;
    bounds.east_deg -= half_px;
  }
  if (bounds.west_deg >= bounds.east_deg || bounds.south_deg >= bounds.north_deg) return;
  const size_t columns = lon_deg.size();
  std::vector<size_t> voids;
  for (size_t j = 0; j < lat_deg.size(); ++j) {
    if (lat_deg[j] < bounds.south_deg || lat_deg[j] > bounds.north_deg) continue;
    for (size_t i = 0; i < columns; ++i)
      // Not the sea that a raster leaves out: its bed would rise to the height of the shore.
      if (weight[j * columns + i] < 1.0f && has_longitude(bounds, lon_deg[i]) &&
          !(has_default_ && below.default_msl[j * columns + i] <= 0.0))
        voids.push_back(j * columns + i);
  }
  if (voids.empty()) return;
  // How far the raster is above what lies below it, from the nearest of its coarser pixels that have data: what each
  // leaves open the next one fills, and the last one's rest is 0.
  std::vector<double> lift(voids.size(), 0.0), value;
  std::vector<float> open(voids.size(), 1.0f), share;
  Field coarse;
  for (uint32_t k = reduction + 1; k <= reduction + kVoidReductions; ++k) {
    if (std::min(raster.width_at(k), raster.height_at(k)) < 2) break;
    if (!sample_layer(raster, lat_deg, lon_deg, k, value, share)) continue;
    sample_stack(lat_deg, lon_deg, std::ldexp(raster.pixel_deg(), static_cast<int>(k)), undulation, coarse, layer);
    const bool ellipsoidal = raster.info().vertical == VerticalDatum::ellipsoid;
    for (size_t n = 0; n < voids.size(); ++n) {
      const size_t at = voids[n];
      const float w = open[n] * share[at];
      const double v = ellipsoidal && undulation ? value[at] - undulation[at] : value[at];
      lift[n] += static_cast<double>(w) * (v - coarse.stack_msl[at]);
      open[n] -= w;
    }
  }
  for (size_t n = 0; n < voids.size(); ++n) below.stack_msl[voids[n]] += lift[n];
}

}  // namespace nepho
