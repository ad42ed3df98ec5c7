#include "terrain/white_seas.h"

#include <algorithm>
#include <vector>

#include "terrain/imagery_sampler.h"

namespace nepho {

bool has_white_seas(const BlockCache& picture, const HeightSampler& ground) {
  constexpr size_t kRows = 16, kColumns = 32;
  constexpr double kAnywhereCold_deg = 90.0;  // where ice_field() looks at the colour alone
  const LonLatBounds b = picture.info().bounds;
  const double south = std::max(b.south_deg, -kLeastIceLatitude_deg),
               north = std::min(b.north_deg, kLeastIceLatitude_deg);
  if (south >= north || picture.whole_is_dear()) return false;
  std::vector<double> lat(kRows), lon(kColumns);
  const double row = (north - south) / kRows, column = (b.east_deg - b.west_deg) / kColumns;
  for (size_t j = 0; j < kRows; ++j) lat[j] = south + (static_cast<double>(j) + 0.5) * row;
  for (size_t i = 0; i < kColumns; ++i)
    lon[i] = canonical_lon_deg(b.west_deg + (static_cast<double>(i) + 0.5) * column);
  // Finer than the grid, or coasts would mix with the sea; coarse enough for few blocks.
  const double spacing = 0.25 * std::min(row, column);
  std::vector<float> land(kRows * kColumns), rgbx(land.size() * 4, -1.0f);
  ground.land_field_m(lat, lon, spacing, land.data());
  lay_over(picture, picture.reduction_for(spacing), lat, lon, rgbx.data());
  size_t seen = 0, white = 0;
  for (size_t p = 0; p < land.size(); ++p) {
    const float* rgb = &rgbx[4 * p];
    if (land[p] > 0.0f || std::min({rgb[0], rgb[1], rgb[2]}) < 0.0f) continue;
    ++seen;
    if (ice_field(rgb, kAnywhereCold_deg) > 0.0f) ++white;
  }
  return 2 * white > seen;
}

}  // namespace nepho
