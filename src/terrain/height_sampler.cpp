#include "terrain/height_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/geodetic.h"
#include "terrain/height_layer.h"
#include "terrain/imagery_sampler.h"
#include "terrain/raster_window.h"

namespace nepho {

namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180.0;

}  // namespace

double canonical_lon_deg(double lon_deg) {
  if (lon_deg >= -180.0 && lon_deg < 180.0) return lon_deg;
  return lon_deg - 360.0 * std::floor((lon_deg + 180.0) / 360.0);
}

HeightSampler::HeightSampler(std::vector<std::shared_ptr<Raster>> elevation, bool has_default,
                             std::shared_ptr<const Geoid> geoid, RasterCaches caches)
    : caches_(std::move(caches)), has_default_(has_default && !elevation.empty()), geoid_(std::move(geoid)) {
  for (auto& raster : elevation) {
    if (raster->info().vertical == VerticalDatum::ellipsoid) needs_undulation_ = true;
    layers_.push_back(std::make_unique<BlockCache>(std::move(raster), caches_));
  }
  find_range();
}

void HeightSampler::find_range() {
  // The default Earth is known: its land lies between the geoid and Mt Everest.
  double lowest = 0.0, highest = has_default_ ? 6100.0 : 0.0;
  for (size_t i = has_default_ ? 1 : 0; i < layers_.size(); ++i) {
    const BlockCache& raster = *layers_[i];
    uint32_t k = 0;
    while (std::max(raster.width_at(k), raster.height_at(k)) > Raster::kBlockSize) ++k;
    uint32_t step = 1;
    if (raster.whole_is_dear()) {
      // A few blocks of it, and what there is on the Earth.
      constexpr uint32_t kBlocksAcross = 4;
      k = 0;
      step = std::max(raster.width_at(0), raster.height_at(0)) / raster.side_at(0) / kBlocksAcross + 1;
      lowest = std::min(lowest, -450.0);
      highest = std::max(highest, 6100.0);
    }
    const uint32_t side = raster.side_at(k);
    for (uint32_t by = step / 2; by * side < raster.height_at(k); by += step)
      for (uint32_t bx = step / 2; bx * side < raster.width_at(k); bx += step) {
        const auto block = raster.block(k, bx, by);
        for (size_t p = 0; p < block->data.valid.size(); ++p) {
          if (!block->data.valid[p]) continue;
          lowest = std::min(lowest, static_cast<double>(block->data.values[p]));
          highest = std::max(highest, static_cast<double>(block->data.values[p]));
        }
      }
  }
  deepest_land_m_ = 300.0 - 1.5 * lowest;
  highest_land_m_ = 300.0 + 1.5 * highest;
}

double HeightSampler::undulation_m(double lat_deg, double lon_deg) const {
  return geoid_ ? geoid_->undulation_m(rad_from_deg(lat_deg), rad_from_deg(lon_deg)) : 0.0;
}

void HeightSampler::sample_stack(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                                 const double* undulation, Field& out, size_t layers) const {
  const size_t count = lat_deg.size() * lon_deg.size();
  out.stack_msl.assign(count, 0.0);
  out.stack_weight.assign(count, 0.0f);
  if (undulation)
    for (size_t i = 0; i < count; ++i) out.stack_msl[i] = -undulation[i];
  out.default_msl.clear();
  std::vector<double> value;
  std::vector<float> weight;
  for (size_t l = 0; l < std::min(layers, layers_.size()); ++l) {
    const BlockCache& raster = *layers_[l];
    const bool is_default = l == 0 && has_default_;
    if (is_default) out.default_msl.assign(count, -std::numeric_limits<double>::infinity());
    const uint32_t reduction = raster.reduction_for(spacing_deg);
    if (!sample_layer(raster, lat_deg, lon_deg, reduction, value, weight)) {
      if (is_default || !overlaps_grid(raster.info().bounds, lat_deg, lon_deg)) continue;
      value.assign(count, 0.0);  // nothing but a void
      weight.assign(count, 0.0f);
    }
    if (!is_default) fill_voids(l, lat_deg, lon_deg, undulation, reduction, weight, out);
    const bool ellipsoidal = raster.info().vertical == VerticalDatum::ellipsoid;
    for (size_t i = 0; i < count; ++i) {
      if (weight[i] <= 0.0f) continue;
      const double v = ellipsoidal && undulation ? value[i] - undulation[i] : value[i];
      if (weight[i] >= 1.0f) {
        out.stack_msl[i] = v;
        out.stack_weight[i] = 1.0f;
      } else {
        const auto w = static_cast<double>(weight[i]);
        out.stack_msl[i] = out.stack_msl[i] * (1.0 - w) + v * w;
        out.stack_weight[i] = std::max(out.stack_weight[i], weight[i]);
      }
    }
    if (!is_default) continue;
    for (size_t i = 0; i < count; ++i)
      if (weight[i] > 0.0f) out.default_msl[i] = value[i];
    const std::vector<double> lift = edge_lift(lat_deg, lon_deg, spacing_deg, undulation, out.default_msl, layers);
    for (size_t i = 0; i < lift.size(); ++i) out.stack_msl[i] += lift[i];
  }
}

void HeightSampler::heights_m(std::span<const double> lat_deg, std::span<const double> lon_deg, uint32_t level,
                              double* out) const {
  const size_t columns = lon_deg.size(), count = columns * lat_deg.size();
  std::vector<double> lon(columns);
  for (size_t i = 0; i < columns; ++i) lon[i] = canonical_lon_deg(lon_deg[i]);
  const std::vector<double> undulation = undulations_m(lat_deg, lon);
  Field field;
  sample_stack(lat_deg, lon, vertex_spacing_deg(level), undulation.data(), field);
  for (size_t i = 0; i < count; ++i) {
    // -N + N is exactly 0: the plain ellipsoid.
    out[i] = (is_sea(field, i) ? 0.0 : field.stack_msl[i]) + undulation[i];
  }
  for (size_t j = 0; j < lat_deg.size(); ++j) {
    if (std::abs(lat_deg[j]) < 90.0 || (columns == 1 && lon[0] == -180.0 && level == kMaxTileLevel)) continue;
    const double west[] = {-180.0}, pole[] = {lat_deg[j]};
    double h = 0.0;
    heights_m(pole, west, kMaxTileLevel, &h);
    std::fill_n(out + j * columns, columns, h);
  }
}

std::vector<double> HeightSampler::undulations_m(std::span<const double> lat_deg,
                                                 std::span<const double> lon_deg) const {
  std::vector<double> out(lat_deg.size() * lon_deg.size());
  for (size_t j = 0; j < lat_deg.size(); ++j)
    for (size_t i = 0; i < lon_deg.size(); ++i) out[j * lon_deg.size() + i] = undulation_m(lat_deg[j], lon_deg[i]);
  return out;
}

bool HeightSampler::is_sea(const Field& field, size_t place) const {
  return field.stack_msl[place] <= 0.0 && field.stack_weight[place] >= 0.5f &&
         (!has_default_ || field.default_msl[place] <= 0.0);
}

void HeightSampler::drawn_msl_m(std::span<const double> lat_deg, std::span<const double> lon_deg, uint32_t level,
                                double* out) const {
  std::vector<double> undulation;
  if (needs_undulation_) undulation = undulations_m(lat_deg, lon_deg);
  Field field;
  sample_stack(lat_deg, lon_deg, vertex_spacing_deg(level), needs_undulation_ ? undulation.data() : nullptr, field);
  for (size_t i = 0; i < field.stack_msl.size(); ++i) out[i] = is_sea(field, i) ? 0.0 : field.stack_msl[i];
}

double HeightSampler::height_m(double lat_rad, double lon_rad, uint32_t level) const {
  const double lat[] = {deg_from_rad(lat_rad)}, lon[] = {deg_from_rad(lon_rad)};
  double h = 0.0;
  heights_m(lat, lon, level, &h);
  return h;
}

void HeightSampler::land_field_m(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                                 float* out) const {
  const size_t columns = lon_deg.size(), count = columns * lat_deg.size();
  std::vector<double> undulation;
  if (needs_undulation_) undulation = undulations_m(lat_deg, lon_deg);
  Field field;
  sample_stack(lat_deg, lon_deg, spacing_deg, needs_undulation_ ? undulation.data() : nullptr, field);
  for (size_t i = 0; i < count; ++i) {
    double land = field.stack_msl[i];
    if (has_default_) land = std::max(land, field.default_msl[i]);
    if (field.stack_weight[i] < 0.5f) land = 1000.0;
    out[i] = static_cast<float>(land);
  }
  if (!water_mask_) return;
  // So dark that every place which the mask does not cover wholly stays darker than any picture.
  constexpr float kUncovered = -1e5f;
  std::vector<float> rgbx(count * 4, kUncovered);
  lay_over(*water_mask_, water_mask_->reduction_for(spacing_deg), lat_deg, lon_deg, rgbx.data());
  for (size_t i = 0; i < count; ++i)
    if (rgbx[4 * i] > -1.0f) out[i] = 127.5f - rgbx[4 * i];
}

HeightSampler::Origin HeightSampler::origin_at(double lat_deg, double lon_deg) const {
  const double lat[] = {lat_deg}, lon[] = {canonical_lon_deg(lon_deg)}, spacing_deg = vertex_spacing_deg(kMaxTileLevel);
  Field field;
  const double undulation[] = {undulation_m(lat_deg, lon[0])};
  sample_stack(lat, lon, spacing_deg, undulation, field);
  Origin origin{.sea = is_sea(field, 0)};
  std::vector<double> value;
  std::vector<float> weight;
  float left = 1.0f, largest = 0.0f;  // what the layers above let through
  for (size_t l = layers_.size(); l-- > 0 && left > largest;) {
    if (!sample_layer(*layers_[l], lat, lon, layers_[l]->reduction_for(spacing_deg), value, weight)) continue;
    const float share = left * weight[0];
    if (share > largest) {
      largest = share;
      origin.layer = static_cast<int>(l);
    }
    left -= share;
  }
  if (left > largest) origin.layer = -1;  // the plain ellipsoid has most
  return origin;
}

void HeightSampler::slopes(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                           Slope* out) const {
  const size_t columns = lon_deg.size(), rows = lat_deg.size(), count = columns * rows;
  std::fill_n(out, count, Slope{});
  std::vector<double> east, west, north, south, lon_e(columns), lon_w(columns), lat_n(rows), lat_s(rows);
  std::vector<float> we, ww, wn, ws;
  for (const auto& layer : layers_) {
    const uint32_t k = layer->reduction_for(spacing_deg);
    const double half = 0.5 * std::max(spacing_deg, layer->pixel_deg());
    for (size_t i = 0; i < columns; ++i) {
      lon_e[i] = lon_deg[i] + half;
      lon_w[i] = lon_deg[i] - half;
    }
    for (size_t j = 0; j < rows; ++j) {
      lat_n[j] = std::min(90.0, lat_deg[j] + half);
      lat_s[j] = std::max(-90.0, lat_deg[j] - half);
    }
    if (!sample_layer(*layer, lat_deg, lon_e, k, east, we) || !sample_layer(*layer, lat_deg, lon_w, k, west, ww) ||
        !sample_layer(*layer, lat_n, lon_deg, k, north, wn) || !sample_layer(*layer, lat_s, lon_deg, k, south, ws))
      continue;
    if (layer.get() == default_data()) {
      add_edge_lift(lat_deg, lon_e, spacing_deg, east);
      add_edge_lift(lat_deg, lon_w, spacing_deg, west);
      add_edge_lift(lat_n, lon_deg, spacing_deg, north);
      add_edge_lift(lat_s, lon_deg, spacing_deg, south);
    }
    for (size_t j = 0; j < rows; ++j) {
      // Near a pole a step in longitude is hardly a step at all: damped there, or noise would stand upright.
      const double cos_lat = std::max(std::cos(rad_from_deg(lat_deg[j])), 0.05);
      const double per_m_east = 1.0 / (2.0 * half * kMetresPerDegree * cos_lat);
      const double per_m_north = 1.0 / ((lat_n[j] - lat_s[j]) * kMetresPerDegree);
      for (size_t i = 0; i < columns; ++i) {
        const size_t p = j * columns + i;
        const float w = std::min(std::min(we[p], ww[p]), std::min(wn[p], ws[p]));
        if (w <= 0.0f) continue;
        out[p].east += w * (static_cast<float>((east[p] - west[p]) * per_m_east) - out[p].east);
        out[p].north += w * (static_cast<float>((north[p] - south[p]) * per_m_north) - out[p].north);
      }
    }
  }
}

double HeightSampler::finest_pixel_deg(const TileBounds& tile) const {
  double finest = std::numeric_limits<double>::infinity();
  for (const auto& layer : layers_)
    if (overlaps(layer->info().bounds, tile)) finest = std::min(finest, layer->pixel_deg());
  return finest;
}

std::vector<SourceStats> HeightSampler::source_stats() const {
  std::vector<SourceStats> all;
  for (const auto& layer : layers_) all.push_back(layer->stats());
  if (water_mask_) all.push_back(water_mask_->stats());
  return all;
}

uint64_t HeightSampler::blocks_read() const {
  uint64_t n = 0;
  for (const auto& layer : layers_) n += layer->blocks_read();
  return n;
}

}  // namespace nepho
