#include "terrain/surface_query.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "terrain/ray_caster.h"
#include "terrain/tile_mesh.h"
#include "terrain/tile_select.h"

namespace nepho {

namespace {

struct Pierced {
  double height_m = 0.0, slope_rad = 0.0;
};

/// The mesh of one level around a place: the place's cell and those around it, because a chord between two vertices of
/// one latitude leaves its parallel.
Pierced pierce(const HeightSampler& ground, double lat_deg, double lon_deg, uint32_t level,
               const Ellipsoid& ellipsoid) {
  const double spacing = vertex_spacing_deg(level);
  const auto rows = static_cast<int64_t>(tile_rows(level)) * kTileQuads;
  const int64_t row = std::clamp(static_cast<int64_t>(std::floor((90.0 - lat_deg) / spacing)), int64_t{0}, rows - 1);
  const auto column = static_cast<int64_t>(std::floor((canonical_lon_deg(lon_deg) + 180.0) / spacing));
  std::vector<double> lats, lons;
  for (int64_t j = std::max(row - 1, int64_t{0}); j <= std::min(row + 2, rows); ++j)
    lats.push_back(90.0 - static_cast<double>(j) * spacing);
  for (int64_t i = column - 1; i <= column + 2; ++i)
    lons.push_back(canonical_lon_deg(-180.0 + static_cast<double>(i) * spacing));
  std::vector<double> heights(lats.size() * lons.size());
  ground.heights_m(lats, lons, level, heights.data());
  std::vector<dvec3> p(heights.size());
  grid_positions(lats, lons, heights.data(), ellipsoid, p.data());

  const double lat_rad = rad_from_deg(lat_deg), lon_rad = rad_from_deg(lon_deg);
  const dvec3 foot = ecef_from_geodetic({lat_rad, lon_rad, 0.0}, ellipsoid), up = geodetic_up_ecef(lat_rad, lon_rad);
  for (dvec3& at : p) at -= foot;
  std::optional<Pierced> found;
  const auto look = [&](const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 n = glm::cross(b - a, c - a);
    const double area = glm::length(n);
    // Triangles on the far side of the pole face away.
    if (found || area <= 0.0 || glm::dot(n, up) <= 0.0) return;
    if (const std::optional<double> t = ray_triangle(a, b, c, up))
      found = {*t, std::atan2(glm::length(glm::cross(n, up)), glm::dot(n, up))};
  };
  const size_t columns = lons.size();
  for (size_t j = 0; j + 1 < lats.size(); ++j)
    for (size_t i = 0; i + 1 < columns; ++i) {
      const dvec3 &nw = p[j * columns + i], &ne = p[j * columns + i + 1];
      const dvec3 &sw = p[(j + 1) * columns + i], &se = p[(j + 1) * columns + i + 1];
      look(nw, sw, ne);
      look(ne, sw, se);
    }
  if (found) return *found;
  return {ground.height_m(lat_rad, lon_rad, level), 0.0};  // at a pole, between two triangles' rounding
}

std::string name_of(const HeightSampler& ground, int layer) {
  if (layer < 0) return "ellipsoid";
  const auto wanted = static_cast<size_t>(layer);
  const std::string& path = ground.layer_info(wanted).path;
  const std::string name = source_file_name(path);
  for (size_t l = 0; l < ground.layers(); ++l)
    if (l != wanted && ground.layer_info(l).path != path && source_file_name(ground.layer_info(l).path) == name)
      return path;
  return name;
}

}  // namespace

uint32_t finest_level_at(double lat_deg, double lon_deg) {
  uint32_t level = 0;
  while (level < kMaxTerrainLevel && may_split(tile_at(level, lat_deg, lon_deg))) ++level;
  return level;
}

SurfacePoint surface_at(const HeightSampler& ground, double lat_rad, double lon_rad, const Ellipsoid& ellipsoid) {
  const double lat_deg = deg_from_rad(lat_rad), lon_deg = deg_from_rad(lon_rad);
  const Pierced there = pierce(ground, lat_deg, lon_deg, finest_level_at(lat_deg, lon_deg), ellipsoid);
  const HeightSampler::Origin origin = ground.origin_at(lat_deg, canonical_lon_deg(lon_deg));
  return {.height_m = there.height_m,
          .height_msl_m = there.height_m - ground.undulation_m(lat_deg, canonical_lon_deg(lon_deg)),
          .slope_rad = there.slope_rad,
          .sea = origin.sea,
          .source = name_of(ground, origin.layer)};
}

double surface_height_m(const HeightSampler& ground, double lat_rad, double lon_rad, const Ellipsoid& ellipsoid) {
  const double lat_deg = deg_from_rad(lat_rad), lon_deg = deg_from_rad(lon_rad);
  return pierce(ground, lat_deg, lon_deg, finest_level_at(lat_deg, lon_deg), ellipsoid).height_m;
}

std::string source_file_name(const std::string& path) {
  if (path.find('{') != std::string::npos || path.find('<') != std::string::npos) return path;
  std::string name = path;
  // DRIVER:"file":variable, GPKG:file:table and the like.
  const size_t quote = name.find('"');
  if (quote != std::string::npos) {
    name = name.substr(quote + 1, name.find('"', quote + 1) - quote - 1);
  } else if (const size_t colon = name.find(':');
             colon != std::string::npos && colon > 1 && name.compare(colon, 3, "://") != 0 && name.front() != '/') {
    name = name.substr(colon + 1);
    if (const size_t second = name.rfind(':');
        second != std::string::npos && second > 1 && name.find('/', second) == std::string::npos)
      name.resize(second);
  }
  if (const size_t query = name.find('?'); query != std::string::npos) name.resize(query);
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  const size_t slash = name.rfind('/');
  return slash == std::string::npos || slash + 1 == name.size() ? name : name.substr(slash + 1);
}

}  // namespace nepho
