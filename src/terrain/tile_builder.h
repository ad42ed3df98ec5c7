#pragma once
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "terrain/height_sampler.h"
#include "terrain/imagery_sampler.h"
#include "terrain/tile_mesh.h"
#include "terrain/tile_select.h"

namespace nepho {

/// All that the GPU needs of one tile.
struct TileData {
  std::vector<TileVertex> vertices;           ///< kTileVertices
  std::vector<std::vector<uint8_t>> imagery;  ///< per mip, RGBA: sRGB colour; alpha >= 128 is water
  std::vector<std::vector<uint32_t>> slopes;  ///< per mip, two halves: east and north slope
};

/// Makes tiles from the samplers; thread-safe.
class TileBuilder {
 public:
  TileBuilder(const HeightSampler& ground, const ImagerySampler& imagery, const Ellipsoid& ellipsoid)
      : ground_(ground), imagery_(imagery), ellipsoid_(ellipsoid) {}

  /// Heights and error of a tile: the distance of the next finer level's vertices from its triangles (three times
  /// the RMS, at most the greatest), or
  /// what finer data not looked at may hide, and twice the ellipsoid's sagitta.
  TileMeta make_meta(const TileId& tile) const;
  /// The part of the error that needs no data: sagitta, texture needs, data finer than the vertices.
  double least_error_m(const TileId& tile) const;
  HeightRange height_range() const;
  TileData make_data(const TileId& tile) const;
  /// Where the texels of TileData::imagery lie.
  ImageryGrid grid_of_imagery(const TileId& tile) const {
    return imagery_grid(tile, imagery_.finest_lattice(tile_bounds(tile)));
  }

 private:
  double unseen_relief_m(const TileId& tile) const;
  void make_imagery(const TileId& tile, TileData& out) const;
  void make_slopes(const TileId& tile, TileData& out) const;
  const HeightSampler& ground_;
  const ImagerySampler& imagery_;
  Ellipsoid ellipsoid_;
};

/// Metas of all tiles seen so far, computed on all cores.
class TileMetaCache final : public TileMetaSource {
 public:
  explicit TileMetaCache(const TileBuilder& builder) : builder_(builder) {}
  double least_error_m(const TileId& tile) const override { return builder_.least_error_m(tile); }
  HeightRange height_range() const override { return builder_.height_range(); }
  void prepare(std::span<const TileId> tiles) override;
  const TileMeta& meta(const TileId& tile) override;
  size_t size() const { return metas_.size(); }
  void clear() { metas_.clear(); }

 private:
  const TileBuilder& builder_;
  std::unordered_map<TileId, TileMeta> metas_;
};

/// Size of a texel of a tile's slopes, degrees.
double slope_texel_deg(uint32_t level);

}  // namespace nepho
