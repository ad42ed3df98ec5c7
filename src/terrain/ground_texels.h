#pragma once
#include <glm/vec4.hpp>
#include <vector>

#include "geo/region_map.h"
#include "terrain/height_sampler.h"
#include "terrain/imagery_sampler.h"

namespace nepho {

/// The ground around a place on the nested levels of a map, level by level; rows run from south to north.
struct GroundTexels {
  static constexpr uint32_t kSide = 128;  ///< texels per side of a level
  /// rgb: linear Rec. 709 albedo of the land, times a; a: share of the texel that is land, 0..1.
  std::vector<glm::vec4> albedo;
  std::vector<float> height_m;  ///< of the drawn surface above the ellipsoid, m; the geoid on the sea
};

/// Samples all levels on all cores: every texel is the mean over its area, of heights and colours reduced to it.
GroundTexels sample_ground(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map,
                           const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// Heights alone, with `side` texels per side of a level: the highest of four samples in each, so that crests keep
/// theirs.
std::vector<float> sample_ground_crests(const HeightSampler& heights, const shared::RegionMap& map, uint32_t side,
                                        const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

}  // namespace nepho
