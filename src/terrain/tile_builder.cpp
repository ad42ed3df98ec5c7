#include "terrain/tile_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "terrain/terrain_shared.h"

namespace nepho {

namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180.0;
constexpr uint32_t kImageryTexels = shared::kTerrainImageryTexels;
constexpr double kSlopesAcross = shared::kTerrainSlopeTexels - 2.0 * shared::kTerrainBorderTexels;
constexpr uint32_t kSlopeTexels = shared::kTerrainSlopeTexels;
constexpr uint32_t kBorder = shared::kTerrainBorderTexels;

/// A raster finer than this share of the spacing still has something to tell the next level.
constexpr double kFiner = 0.75;
/// Error that is assumed of data finer than the vertices besides what two levels show: metres per metre of spacing.
constexpr double kUnseenRelief = 0.05;
/// Largest slope texel on screen where the source has more detail, px at a screen error of 1 px.
constexpr double kSlopeTexelPx = 3.0;

/// The same of imagery, for a texel of `pixels` of the source (along each axis). A tile has its own shape in full where
/// its parent's error is kMorphRange times what is allowed. So the finest texels are seen, sharp, where a pixel of the
/// source is a pixel on screen: at 1.25, of a parent whose texels are two pixels; where the finest texels are half a
/// pixel (RasterInfo::oversampling), one level more is needed by then, and the one above has to be beyond that.
double imagery_texel_px(double pixels) {
  if (pixels < 1.2) return 0.7;
  return pixels < 2.4 ? 1.0 : 1.25;
}
/// Coast lines fade over this many texels to each side in alpha: a distance field that stays sharp when magnified.
constexpr float kCoastTexels = 4.0f;

struct TexelGrid {
  std::vector<double> lat, lon;
};

/// Centres of a tile's slope texels, the border beyond the tile included.
TexelGrid slope_grid(const TileId& tile) {
  const TileBounds b = tile_bounds(tile);
  const double step = slope_texel_deg(tile.level);
  TexelGrid g;
  g.lat.resize(kSlopeTexels);
  g.lon.resize(kSlopeTexels);
  for (uint32_t i = 0; i < kSlopeTexels; ++i) {
    const double offset = (static_cast<double>(i) - kBorder + 0.5) * step;
    g.lon[i] = b.west_deg + offset;
    g.lat[i] = std::clamp(b.north_deg - offset, -90.0, 90.0);
  }
  return g;
}

}  // namespace

double slope_texel_deg(uint32_t level) { return tile_size_deg(level) / kSlopesAcross; }

namespace {
constexpr double kDeepestSagitta_m = 100.0;  // an aerosol scale height is 1200 m

/// How deep the middle of a mesh cell's diagonal lies below the ellipsoid.
double sagitta_m(const TileId& tile, const Ellipsoid& ellipsoid) {
  const double spacing_m = vertex_spacing_deg(tile.level) * kMetresPerDegree;
  return spacing_m * spacing_m / (4.0 * ellipsoid.b_m);
}
}  // namespace

double TileBuilder::unseen_relief_m(const TileId& tile) const {
  const double spacing = vertex_spacing_deg(tile.level);
  return ground_.finest_pixel_deg(tile_bounds(tile)) < kFiner * spacing ? kUnseenRelief * spacing * kMetresPerDegree
                                                                        : 0.0;
}

double TileBuilder::least_error_m(const TileId& tile) const {
  // From far out a mesh cell may sink kilometres below the ellipsoid within a pixel. The picture's shape would not
  // mind, but its light would: the lowest kilometre of the air is the densest, and the sea would show the mesh as a
  // grid of dots.
  if (sagitta_m(tile, ellipsoid_) > kDeepestSagitta_m) return std::numeric_limits<double>::infinity();
  // Twice the sagitta: silhouettes keep to half a pixel.
  double error = unseen_relief_m(tile) + 2.0 * sagitta_m(tile, ellipsoid_);
  const TileBounds bounds = tile_bounds(tile);
  const double slope_texel = slope_texel_deg(tile.level);
  const ImageryGrid texels = grid_of_imagery(tile);
  if (texels.coarse_deg > 0.0)
    error =
        std::max(error, texels.coarse_deg * kMetresPerDegree / imagery_texel_px(texels.coarse_deg / texels.source_deg));
  if (ground_.finest_pixel_deg(bounds) < kFiner * slope_texel)
    error = std::max(error, slope_texel * kMetresPerDegree / kSlopeTexelPx);
  return error;
}

HeightRange TileBuilder::height_range() const { return {-ground_.deepest_land_m(), ground_.highest_land_m()}; }

TileMeta TileBuilder::make_meta(const TileId& tile) const {
  const std::vector<double> lats = vertex_lats_deg(tile), lons = vertex_lons_deg(tile);
  constexpr size_t n = kTileVerticesPerSide, fine_n = 2 * kTileQuads + 1;
  const double spacing = vertex_spacing_deg(tile.level), spacing_m = spacing * kMetresPerDegree;
  std::vector<double> fine_lats(fine_n), fine_lons(fine_n);
  for (size_t i = 0; i < fine_n; ++i) {
    fine_lats[i] = lats.front() - static_cast<double>(i) * spacing * 0.5;
    fine_lons[i] = lons.front() + static_cast<double>(i) * spacing * 0.5;
  }
  std::vector<double> own(n * n), fine(fine_n * fine_n);
  ground_.drawn_msl_m(lats, lons, tile.level, own.data());
  ground_.drawn_msl_m(fine_lats, fine_lons, tile.level + 1, fine.data());

  double lowest = own[0], highest = own[0], largest = 0.0, vertical = 0.0, squares = 0.0;
  for (size_t j = 0; j < fine_n; ++j)
    for (size_t i = 0; i < fine_n; ++i) {
      const double f = fine[j * fine_n + i];
      // The triangles' height there: a vertex, the middle of an edge, or of the north-east to south-west diagonal.
      const size_t i0 = i / 2, j0 = j / 2, i1 = (i + 1) / 2, j1 = (j + 1) / 2;
      const double drawn = 0.5 * (own[j0 * n + i1] + own[j1 * n + i0]);
      lowest = std::min({lowest, f, drawn});
      highest = std::max({highest, f, drawn});
      // Vertical distance to distance: on a wall (a void's rim) the one is many times the other.
      const auto [low, high] = std::minmax({own[j0 * n + i0], own[j0 * n + i1], own[j1 * n + i0], own[j1 * n + i1]});
      const double steepness = (high - low) / spacing_m;
      const double distance = std::abs(f - drawn) / std::sqrt(1.0 + steepness * steepness);
      largest = std::max(largest, distance);
      squares += distance * distance;
      vertical = std::max(vertical, std::abs(f - drawn));
    }

  // Three times the RMS, so that one pit or spike does not refine a whole tile.
  const double deviation = std::min(largest, 3.0 * std::sqrt(squares / static_cast<double>(fine.size())));
  const double relief = std::max(vertical, unseen_relief_m(tile));
  double low_n = 1e9, high_n = -1e9;
  for (size_t j = 0; j < n; j += kTileQuads / 4)
    for (size_t i = 0; i < n; i += kTileQuads / 4) {
      const double u = ground_.undulation_m(lats[j], lons[i]);
      low_n = std::min(low_n, u);
      high_n = std::max(high_n, u);
    }
  const double geoid_margin = std::min(60.0, 1.0 + 10.0 * tile_size_deg(tile.level));
  TileMeta meta;
  // Border vertices may be a coarser level's, and data between the finer vertices may stand out.
  meta.heights = {lowest + low_n - geoid_margin - 3.0 * relief, highest + high_n + geoid_margin + 3.0 * relief};
  meta.error_m = std::max(deviation + 2.0 * sagitta_m(tile, ellipsoid_), least_error_m(tile));
  meta.volume = make_tile_volume(tile, meta.heights.min_m, meta.heights.max_m, ellipsoid_);
  return meta;
}

TileData TileBuilder::make_data(const TileId& tile) const {
  TileData out;
  out.vertices = tile_vertices(tile, ground_, ellipsoid_);
  make_imagery(tile, out);
  make_slopes(tile, out);
  return out;
}

void TileBuilder::make_imagery(const TileId& tile, TileData& out) const {
  constexpr uint32_t n = kImageryTexels;
  const ImageryGrid grid = grid_of_imagery(tile);
  const TexelGrid g{grid.lats_deg(), grid.lons_deg()};
  const double texel = grid.texel_deg();
  std::vector<float> land(n * n);
  ground_.land_field_m(g.lat, g.lon, texel, land.data());
  if (std::any_of(land.begin(), land.end(), [](float f) { return f <= 0.0f; })) {
    std::vector<float> shown(land.size());
    imagery_.over_water(g.lat, g.lon, texel, shown.data());
    for (size_t p = 0; p < land.size(); ++p) land[p] = std::max(land[p], shown[p]);
  }
  std::vector<uint8_t> rgba(size_t{n} * n * 4, 0);
  const bool any_land = std::any_of(land.begin(), land.end(), [](float f) { return f > 0.0f; });
  const bool any_sea = std::any_of(land.begin(), land.end(), [](float f) { return f <= 0.0f; });
  if (any_land) {
    std::vector<float> colour(size_t{n} * n * 4);
    imagery_.colours(g.lat, g.lon, texel, colour.data());
    for (size_t p = 0; p < rgba.size(); ++p) rgba[p] = static_cast<uint8_t>(std::clamp(colour[p], 0.0f, 255.0f) + 0.5f);
  }
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) {
      uint8_t& alpha = rgba[(size_t{j} * n + i) * 4 + 3];
      alpha = any_land ? 0 : 255;
      if (!any_land || !any_sea) continue;
      const float f = land[j * n + i];
      const uint32_t i0 = i > 0 ? i - 1 : 0, i1 = std::min(i + 1, n - 1), j0 = j > 0 ? j - 1 : 0,
                     j1 = std::min(j + 1, n - 1);
      const float gx = (land[j * n + i1] - land[j * n + i0]) / static_cast<float>(i1 - i0);
      const float gy = (land[j1 * n + i] - land[j0 * n + i]) / static_cast<float>(j1 - j0);
      // Distance to the coast in texels, from the height and its gradient; flat water at exactly 0 m is all water.
      const float gradient = std::max(std::sqrt(gx * gx + gy * gy), 1e-6f);
      const float water = std::clamp((1e-3f - f) / gradient / kCoastTexels, -1.0f, 1.0f);
      alpha = static_cast<uint8_t>(f <= 0.0f ? 128.0f + 127.0f * std::max(water, 0.0f)
                                             : 127.0f + 127.0f * std::min(water, 0.0f));
    }
  out.imagery.push_back(std::move(rgba));
  for (uint32_t mip = 1; mip < shared::kTerrainImageryMips; ++mip) {
    const std::vector<uint8_t>& from = out.imagery.back();
    const uint32_t side = n >> mip, above = side * 2;
    std::vector<uint8_t> to(size_t{side} * side * 4);
    for (uint32_t j = 0; j < side; ++j)
      for (uint32_t i = 0; i < side; ++i) {
        const size_t at = (size_t{2 * j} * above + 2 * i) * 4, below = at + size_t{above} * 4;
        for (size_t b = 0; b < 4; ++b)
          to[(size_t{j} * side + i) * 4 + b] =
              static_cast<uint8_t>((from[at + b] + from[at + 4 + b] + from[below + b] + from[below + 4 + b] + 2) / 4);
      }
    out.imagery.push_back(std::move(to));
  }
}

void TileBuilder::make_slopes(const TileId& tile, TileData& out) const {
  constexpr uint32_t n = kSlopeTexels;
  const TexelGrid g = slope_grid(tile);
  std::vector<Slope> level(size_t{n} * n);
  ground_.slopes(g.lat, g.lon, slope_texel_deg(tile.level), level.data());
  for (uint32_t mip = 0; mip < shared::kTerrainSlopeMips; ++mip) {
    const uint32_t side = n >> mip;
    std::vector<uint32_t> packed(size_t{side} * side);
    for (size_t p = 0; p < packed.size(); ++p) packed[p] = glm::packHalf2x16(glm::vec2(level[p].east, level[p].north));
    out.slopes.push_back(std::move(packed));
    const uint32_t half = side / 2;
    for (uint32_t j = 0; j < half; ++j)
      for (uint32_t i = 0; i < half; ++i) {
        const Slope &a = level[2 * j * side + 2 * i], &b = level[2 * j * side + 2 * i + 1];
        const Slope &c = level[(2 * j + 1) * side + 2 * i], &d = level[(2 * j + 1) * side + 2 * i + 1];
        // In place: the target never lies behind what is still to be read.
        level[j * half + i] = {0.25f * (a.east + b.east + c.east + d.east),
                               0.25f * (a.north + b.north + c.north + d.north)};
      }
  }
}

void TileMetaCache::prepare(std::span<const TileId> tiles) {
  std::vector<TileId> missing;
  for (const TileId& t : tiles)
    if (!metas_.contains(t)) missing.push_back(t);
  std::vector<TileMeta> made(missing.size());
  parallel_for(missing.size(), [&](size_t i) { made[i] = builder_.make_meta(missing[i]); });
  for (size_t i = 0; i < missing.size(); ++i) metas_.emplace(missing[i], made[i]);
}

const TileMeta& TileMetaCache::meta(const TileId& tile) {
  const auto found = metas_.find(tile);
  if (found != metas_.end()) return found->second;
  return metas_.emplace(tile, builder_.make_meta(tile)).first->second;
}

}  // namespace nepho
