#pragma once
#include <glm/vec4.hpp>

#include "geo/region_map.h"
#include "terrain/ground_texels.h"
#include "terrain_fixture.h"

namespace nepho::test {

/// Smooth heights and one smooth colour all over the Earth, without any seam.
inline dvec3 up_at(double lat_deg, double lon_deg) {
  return geodetic_up_ecef(rad_from_deg(lat_deg), rad_from_deg(lon_deg));
}
inline double smooth_height_m(const dvec3& up) { return 1500.0 + 500.0 * up.x - 300.0 * up.y + 400.0 * up.z; }
inline double smooth_srgb(const dvec3& up) { return 120.0 + 30.0 * up.x + 40.0 * up.y - 50.0 * up.z; }

inline std::shared_ptr<ArrayRaster> smooth_elevation() {
  return raster_of(720, 360, {}, [](double lat, double lon) { return smooth_height_m(up_at(lat, lon)); });
}
/// Grey.
inline std::shared_ptr<ArrayRaster> smooth_imagery() {
  return raster_of(720, 360, {}, [](double lat, double lon) { return smooth_srgb(up_at(lat, lon)); });
}

/// IEC 61966-2-1, 0..255 to 0..1.
inline double linear_from_srgb(double srgb_255) {
  const double v = srgb_255 / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

inline shared::RegionMap map_at(double lat_deg, double lon_deg, uint32_t levels = 11, double half_m = 10e3) {
  return make_region_map(ecef_from_geodetic(Geodetic::from_degrees(lat_deg, lon_deg)), half_m, levels);
}

inline double texel_m(const shared::RegionMap& map, uint32_t level) {
  return 2.0 * static_cast<double>(shared::region_half_m(map, level)) / GroundTexels::kSide;
}

/// The place of a texel's centre; false beyond the antipode.
inline bool texel_place(const shared::RegionMap& map, uint32_t level, uint32_t i, uint32_t j, Geodetic& at) {
  const double half = static_cast<double>(shared::region_half_m(map, level)), step = texel_m(map, level);
  const glm::dvec2 xy((i + 0.5) * step - half, (j + 0.5) * step - half);
  if (glm::length(xy) > 1.9 * static_cast<double>(map.radius_m)) return false;
  at = geodetic_from_map_direction(dvec3(shared::region_direction(map, glm::vec2(xy))));
  return true;
}

}  // namespace nepho::test
