#include "terrain/ground_texels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "terrain/tile_reads.h"

namespace nepho {

namespace {

constexpr double kMetresPerDegree = 6371008.8 * std::numbers::pi / 180.0;
constexpr size_t kSide = GroundTexels::kSide;
/// Samples per side of a texel.
constexpr size_t kSub = 2;
constexpr size_t kSubSide = kSide * kSub;
/// Whether a sample is land is read from elevation this much finer than the samples: the mean height of a coast is
/// below the sea, however much of it is land.
constexpr double kCoastDetail = 4.0;
constexpr size_t kMostColumns = 4096;
constexpr size_t kRowsPerTask = 8;

/// sRGB, 0..255, to linear 0..1 (IEC 61966-2-1).
float linear_from_srgb(float srgb_255) {
  const float v = std::clamp(srgb_255 / 255.0f, 0.0f, 1.0f);
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

struct Place {
  double lat_deg, lon_deg;  // longitude from the centre's, -180..180
};

/// Equidistant values that hold `low`..`high`.
struct Axis {
  double first = 0.0, step = 1.0;
  size_t count = 2;
  Axis(double low, double high, double spacing, size_t most) {
    count = std::min(static_cast<size_t>(std::ceil((high - low) / spacing)) + 1, most);
    count = std::max(count, size_t{2});
    first = low;
    step = (high - low) / static_cast<double>(count - 1);
  }
  double at(size_t i) const { return first + step * static_cast<double>(i); }
  /// The value's lower neighbour, and its distance from it in steps.
  size_t below(double value, float& f) const {
    const double x = std::clamp((value - first) / step, 0.0, static_cast<double>(count - 1));
    const size_t i = std::min(static_cast<size_t>(x), count - 2);
    f = static_cast<float>(x - static_cast<double>(i));
    return i;
  }
};

/// What the samplers say on a grid of latitudes and longitudes, which is how they work.
struct Grid {
  Axis lat, lon;
  std::vector<glm::vec4> albedo;  // as GroundTexels; empty without imagery
  std::vector<float> height_m;

  float height_at(const Place& p) const {
    float fx = 0.0f, fy = 0.0f;
    const size_t a = lat.below(p.lat_deg, fy) * lon.count + lon.below(p.lon_deg, fx), b = a + lon.count;
    return (height_m[a] * (1.0f - fx) + height_m[a + 1] * fx) * (1.0f - fy) +
           (height_m[b] * (1.0f - fx) + height_m[b + 1] * fx) * fy;
  }
};

uint32_t tile_level_for(double spacing_deg) {
  uint32_t level = 0;
  while (level < kMaxTileLevel && vertex_spacing_deg(level) > spacing_deg * (1.0 + 1e-9)) ++level;
  return level;
}

Grid sample_grid(const HeightSampler& heights, const ImagerySampler* imagery, const std::vector<Place>& places,
                 double centre_lon_deg, double spacing_deg) {
  double south = 90.0, north = -90.0, west = 180.0, east = -180.0;
  for (const Place& p : places) {
    south = std::min(south, p.lat_deg);
    north = std::max(north, p.lat_deg);
    west = std::min(west, p.lon_deg);
    east = std::max(east, p.lon_deg);
  }
  const double lowest = south < 0.0 && north > 0.0 ? 0.0 : std::min(std::abs(south), std::abs(north));
  const double lon_spacing_deg = spacing_deg / std::max(std::cos(rad_from_deg(lowest)), 1e-6);
  Grid grid{Axis(std::max(south - 1e-9, -90.0), std::min(north + 1e-9, 90.0), spacing_deg, kMostColumns),
            Axis(west - 1e-9, east + 1e-9, lon_spacing_deg, kMostColumns),
            {},
            {}};
  const size_t columns = grid.lon.count, rows = grid.lat.count;
  if (imagery) grid.albedo.resize(columns * rows);
  grid.height_m.resize(columns * rows);
  std::vector<double> lon_deg(columns);
  for (size_t i = 0; i < columns; ++i) lon_deg[i] = centre_lon_deg + grid.lon.at(i);
  const uint32_t level = tile_level_for(spacing_deg);
  TileReads* const caller = TileReads::current();
  parallel_for((rows + kRowsPerTask - 1) / kRowsPerTask, [&](size_t task) {
    const TileReads reads(caller);
    const size_t first = task * kRowsPerTask, last = std::min(first + kRowsPerTask, rows);
    std::vector<double> lat_deg;
    for (size_t j = first; j < last; ++j) lat_deg.push_back(grid.lat.at(j));
    const size_t count = lat_deg.size() * columns;
    std::vector<double> height_m(count);
    heights.heights_m(lat_deg, lon_deg, level, height_m.data());
    for (size_t p = 0; p < count; ++p) grid.height_m[first * columns + p] = static_cast<float>(height_m[p]);
    if (!imagery) return;
    std::vector<float> land(count), shown(count), srgb(count * 4);
    heights.land_field_m(lat_deg, lon_deg, spacing_deg / kCoastDetail, land.data());
    imagery->over_water(lat_deg, lon_deg, spacing_deg, shown.data());
    for (size_t p = 0; p < count; ++p) land[p] = std::max(land[p], shown[p]);
    if (std::any_of(land.begin(), land.end(), [](float f) { return f > 0.0f; }))
      imagery->colours(lat_deg, lon_deg, spacing_deg, srgb.data());
    for (size_t p = 0; p < count; ++p) {
      glm::vec4& albedo = grid.albedo[first * columns + p];
      albedo = glm::vec4(0.0f);
      if (land[p] <= 0.0f) continue;
      for (int c = 0; c < 3; ++c) albedo[c] = linear_from_srgb(srgb[p * 4 + static_cast<size_t>(c)]);
      albedo.a = 1.0f;
    }
  });
  return grid;
}

/// The centres of a level's side^2 texels, row by row; their spacing in m.
double place_texels(const shared::RegionMap& map, uint32_t level, size_t side, double centre_lon_deg,
                    const Ellipsoid& ellipsoid, std::vector<Place>& places) {
  const auto half_m = static_cast<double>(shared::region_half_m(map, level));
  const double spacing_m = 2.0 * half_m / static_cast<double>(side);
  places.resize(side * side);
  parallel_for(side, [&](size_t j) {
    for (size_t i = 0; i < side; ++i) {
      const glm::vec2 xy(glm::dvec2((static_cast<double>(i) + 0.5) * spacing_m - half_m,
                                    (static_cast<double>(j) + 0.5) * spacing_m - half_m));
      const Geodetic at = geodetic_from_map_direction(dvec3(shared::region_direction(map, xy)), ellipsoid);
      places[j * side + i] = {at.lat_deg(), std::remainder(at.lon_deg() - centre_lon_deg, 360.0)};
    }
  });
  return spacing_m;
}

}  // namespace

GroundTexels sample_ground(const HeightSampler& heights, const ImagerySampler& imagery, const shared::RegionMap& map,
                           const Ellipsoid& ellipsoid) {
  GroundTexels out;
  out.albedo.resize(kSide * kSide * map.levels);
  out.height_m.resize(kSide * kSide * map.levels);
  const double centre_lon_deg = geodetic_from_map_direction(dvec3(map.centre), ellipsoid).lon_deg();
  std::vector<Place> places;
  for (uint32_t level = 0; level < map.levels; ++level) {
    const double spacing_m = place_texels(map, level, kSubSide, centre_lon_deg, ellipsoid, places);
    const Grid grid = sample_grid(heights, &imagery, places, centre_lon_deg, spacing_m / kMetresPerDegree);
    parallel_for(kSide, [&](size_t j) {
      for (size_t i = 0; i < kSide; ++i) {
        glm::vec4 albedo(0.0f);
        float height_m = 0.0f;
        for (size_t s = 0; s < kSub * kSub; ++s) {
          const Place& p = places[(j * kSub + s / kSub) * kSubSide + i * kSub + s % kSub];
          float fx = 0.0f, fy = 0.0f;
          const size_t a = grid.lat.below(p.lat_deg, fy) * grid.lon.count + grid.lon.below(p.lon_deg, fx);
          const size_t b = a + grid.lon.count;
          const auto mixed = [&](const auto& v) {
            return (v[a] * (1.0f - fx) + v[a + 1] * fx) * (1.0f - fy) + (v[b] * (1.0f - fx) + v[b + 1] * fx) * fy;
          };
          albedo += mixed(grid.albedo);
          height_m += mixed(grid.height_m);
        }
        const size_t texel = (level * kSide + j) * kSide + i;
        out.albedo[texel] = albedo / static_cast<float>(kSub * kSub);
        out.height_m[texel] = height_m / static_cast<float>(kSub * kSub);
      }
    });
  }
  return out;
}

std::vector<float> sample_ground_crests(const HeightSampler& heights, const shared::RegionMap& map, uint32_t side,
                                        const Ellipsoid& ellipsoid) {
  std::vector<float> out;
  out.reserve(size_t{side} * side * map.levels);
  const double centre_lon_deg = geodetic_from_map_direction(dvec3(map.centre), ellipsoid).lon_deg();
  std::vector<Place> places;
  const size_t sub_side = kSub * side;
  for (uint32_t level = 0; level < map.levels; ++level) {
    const double spacing_m = place_texels(map, level, sub_side, centre_lon_deg, ellipsoid, places);
    const Grid grid = sample_grid(heights, nullptr, places, centre_lon_deg, spacing_m / kMetresPerDegree);
    for (size_t j = 0; j < side; ++j)
      for (size_t i = 0; i < side; ++i) {
        float highest_m = -1e9f;
        for (size_t s = 0; s < kSub * kSub; ++s)
          highest_m =
              std::max(highest_m, grid.height_at(places[(j * kSub + s / kSub) * sub_side + i * kSub + s % kSub]));
        out.push_back(highest_m);
      }
  }
  return out;
}

}  // namespace nepho
