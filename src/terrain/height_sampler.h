#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geo/geoid.h"
#include "geo/lonlat_tiles.h"
#include "io/raster.h"
#include "terrain/block_cache.h"

namespace nepho {

/// Quads per side of a tile's mesh.
inline constexpr uint32_t kTileQuads = 64;

/// Distance of two mesh vertices at a level, degrees; exact in double.
constexpr double vertex_spacing_deg(uint32_t level) { return tile_size_deg(level) / kTileQuads; }

/// East and north derivative of the ground's height, m per m.
struct Slope {
  float east = 0.0f, north = 0.0f;
};

/// Heights of the drawn surface from a stack of elevation rasters. Deterministic: a place and a level give the same
/// bits whichever grid it is part of and whatever was asked before. Thread-safe.
///
/// Rasters lie over each other, the bottom one over the plain ellipsoid; where a raster has no data, and half a pixel
/// beyond its last one, what lies below shows, blended by the bilinear weight of the valid pixels. The default data are
/// lifted to a finer raster's edge around it (edge_lift()), and in its voids. Heights above EGM96
/// get the geoid's undulation. Sea is where both the default data and the stack are at or below 0: there the surface is
/// the geoid. Without default data the stack decides alone.
///
/// Water is the sea, or what a mask says: it changes what the ground is made of, never its height.
class HeightSampler {
 public:
  HeightSampler(std::vector<std::shared_ptr<Raster>> elevation, bool has_default, std::shared_ptr<const Geoid> geoid,
                RasterCaches caches = {});

  HeightSampler(const HeightSampler&) = delete;
  HeightSampler& operator=(const HeightSampler&) = delete;

  /// A picture of water, white (from 128 of 255), and land: decides where it has data; elsewhere the sea is water. Call
  /// before anything is sampled.
  void set_water_mask(std::shared_ptr<Raster> mask) {
    water_mask_ = std::make_unique<BlockCache>(std::move(mask), caches_);
  }

  /// Height above the ellipsoid, m, with the rasters reduced to suit the vertices of `level`.
  double height_m(double lat_rad, double lon_rad, uint32_t level) const;
  /// The same at every place of a grid, row by row: out[row * lon_deg.size() + column]. At the poles all longitudes and
  /// levels give one height.
  void heights_m(std::span<const double> lat_deg, std::span<const double> lon_deg, uint32_t level, double* out) const;

  /// Heights of the drawn surface above the geoid: 0 on the sea. Above the ellipsoid where no raster has data or the
  /// geoid is missing. Cheaper than heights_m(); poles are not treated.
  void drawn_msl_m(std::span<const double> lat_deg, std::span<const double> lon_deg, uint32_t level, double* out) const;

  /// Positive on land, at most 0 on water, continuous: the higher of the default data and the stack, m above the geoid;
  /// everything is land where no raster has data. Within a water mask its levels below 127.5.
  void land_field_m(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                    float* out) const;

  /// Slope of the ground (the sea bed included), smoothed over one pixel of the raster it comes from, so that it is
  /// continuous although the heights are bilinear.
  void slopes(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg, Slope* out) const;

  /// What decides the height at a place, at full resolution.
  struct Origin {
    int layer = -1;    ///< of the stack, bottom 0: the raster with the largest share; -1 where none has data
    bool sea = false;  ///< its number is at or below 0, and the surface is the geoid
  };
  Origin origin_at(double lat_deg, double lon_deg) const;
  size_t layers() const { return layers_.size(); }
  const RasterInfo& layer_info(size_t layer) const { return layers_[layer]->info(); }

  /// Geoid above the ellipsoid, m; 0 without a geoid.
  double undulation_m(double lat_deg, double lon_deg) const;
  /// Pixel size in degrees of the finest raster that overlaps a tile; empty stack: infinity.
  double finest_pixel_deg(const TileBounds& tile) const;
  /// How far below the ellipsoid land may lie, m: a guess from the rasters' coarsest reductions with a wide margin.
  double deepest_land_m() const { return deepest_land_m_; }
  /// How high above the ellipsoid land may rise, m; found in the same way.
  double highest_land_m() const { return highest_land_m_; }
  const BlockCache* default_data() const { return has_default_ ? layers_.front().get() : nullptr; }
  uint64_t blocks_read() const;
  /// What became of the blocks of every raster: the stack, bottom first, then the water mask.
  std::vector<SourceStats> source_stats() const;

 private:
  struct Field {
    std::vector<double> stack_msl;    // NaN never: plain ellipsoid is -undulation
    std::vector<double> default_msl;  // has_default only
    std::vector<float> stack_weight;  // share of the place that any raster covers
  };
  /// The rasters below `layers`, or all.
  void sample_stack(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                    const double* undulation_m, Field& out, size_t layers = SIZE_MAX) const;
  /// Lifts what lies below a raster's voids by as much as the raster is above it around them.
  void fill_voids(size_t layer, std::span<const double> lat_deg, std::span<const double> lon_deg,
                  const double* undulation_m, uint32_t reduction, const std::vector<float>& weight, Field& below) const;
  /// How far the default data are lifted around rasters of the stack, from the second to below `layers`, m: at a
  /// raster's edge by as much as it is above them, less and less over the next 1.5 pixels of theirs; not at the sea.
  /// Empty where no raster is near. `inside`: on the raster, too, all of the way to it.
  std::vector<double> edge_lift(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                                const double* undulation_m, std::span<const double> default_msl, size_t layers,
                                bool inside = false) const;
  /// Lifts default data, as they are at the places of a grid, in this way, so that differences across an edge fit.
  void add_edge_lift(std::span<const double> lat_deg, std::span<const double> lon_deg, double spacing_deg,
                     std::vector<double>& default_msl) const;
  std::vector<double> undulations_m(std::span<const double> lat_deg, std::span<const double> lon_deg) const;
  bool is_sea(const Field& field, size_t place) const;
  void find_range();

  RasterCaches caches_;
  std::vector<std::unique_ptr<BlockCache>> layers_;  // bottom first
  std::unique_ptr<BlockCache> water_mask_;           // may be null
  bool has_default_ = false;
  std::shared_ptr<const Geoid> geoid_;
  bool needs_undulation_ = false;  // some raster is above the ellipsoid
  double deepest_land_m_ = 0.0, highest_land_m_ = 0.0;
};

/// A longitude in [-180, 180): the two sides of the antimeridian are one place.
double canonical_lon_deg(double lon_deg);

}  // namespace nepho
