#include "terrain/tile_select.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>

#include "terrain/ray_caster.h"
#include "terrain/tile_builder.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

struct World {
  explicit World(std::vector<std::shared_ptr<Raster>> rasters)
      : ground(std::move(rasters), false, nullptr), imagery({}, ground), builder(ground, imagery, {}), metas(builder) {}
  HeightSampler ground;
  ImagerySampler imagery;
  TileBuilder builder;
  TileMetaCache metas;
};

struct Camera {
  double lat, lon, height, heading, pitch, fov;
};
const Camera kCameras[] = {
    {35.5, 138.7, 5000.0, 0.0, 0.0, 45.0},    {35.5, 138.7, 4100.0, 200.0, -30.0, 90.0},
    {0.0, 180.0, 12000.0, 90.0, -15.0, 60.0}, {90.0, 0.0, 8000.0, 45.0, -20.0, 60.0},
    {-89.9, 77.0, 400e3, 10.0, -70.0, 60.0},  {20.0, -179.9, 400e3, 270.0, -20.0, 60.0},
    {10.0, 20.0, 36e6, 0.0, -90.0, 20.0},     {-40.0, 100.0, 3e6, 120.0, -45.0, 60.0},
    {51.5, 0.0, 20e3, 300.0, -5.0, 120.0},
};

bool holds(const std::set<TileId>& tiles, double lat, double lon) {
  for (uint32_t level = 0; level <= kMaxTerrainLevel; ++level)
    if (tiles.contains(tile_at(level, lat, lon))) return true;
  return false;
}

}  // namespace

TEST_CASE("every ray that hits the ellipsoid hits it in a selected tile") {
  World world({});
  std::mt19937 random(7);
  for (const Camera& c : kCameras) {
    const Geodetic at = Geodetic::from_degrees(c.lat, c.lon, c.height);
    const Attitude attitude = Attitude::from_degrees(c.heading, c.pitch);
    const FrameInfo frame = frame_at(at, attitude, c.fov, {640, 360});
    std::set<TileId> tiles;
    for (const SelectedTile& s : select_tiles(view_at(at, attitude, c.fov, {640, 360}), world.metas))
      tiles.insert(s.tile);
    std::uniform_real_distribution<double> x(0.0, 640.0), y(0.0, 360.0);
    size_t hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const dvec3 ray = pixel_ray(frame, x(random), y(random));
      const double t = hit_ellipsoid(frame.camera_ecef_m, ray);
      if (t < 0.0) continue;
      ++hits;
      const Geodetic hit = geodetic_from_ecef(frame.camera_ecef_m + ray * t);
      REQUIRE(holds(tiles, hit.lat_deg(), hit.lon_deg()));
    }
    CHECK(hits > 400);
  }
}

TEST_CASE("touching tiles are at most one level apart and do not overlap") {
  World world({rough_world()});
  for (const Camera& c : kCameras) {
    const auto selected = select_tiles(view_at(Geodetic::from_degrees(c.lat, c.lon, c.height),
                                               Attitude::from_degrees(c.heading, c.pitch), c.fov, {640, 360}),
                                       world.metas);
    std::set<TileId> tiles;
    for (const SelectedTile& s : selected) tiles.insert(s.tile);
    CHECK(tiles.size() == selected.size());
    CHECK(tiles.size() < 200);
    for (const TileId& t : tiles) {
      for (uint32_t level = 0; level < t.level; ++level) REQUIRE(!tiles.contains(tile_ancestor(t, level)));
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const auto neighbour = tile_neighbour(t, dx, dy);
          if (!neighbour) continue;
          for (uint32_t level = 0; level + 1 < t.level; ++level)
            REQUIRE(!tiles.contains(tile_ancestor(*neighbour, level)));
        }
    }
  }
}

TEST_CASE("as the camera comes nearer the drawn ground moves by a fraction of a pixel a step, through all levels") {
  // Hills in hills: every level of tiles finds something new.
  World world({raster_of(2048, 1024, {10.0, 9.5, 12.0, 10.5}, [](double lat, double lon) {
    double h = 500.0;
    for (int k = 0; k < 9; ++k) {
      const double f = std::ldexp(20.0, k), a = std::ldexp(800.0, -k);
      h += a * std::sin(f * (lon + 0.3 * k)) * std::cos(f * (lat - 0.7 * k));
    }
    return h;
  })});
  const double step = 0.96;
  std::vector<double> before;
  double worst_px = 0.0;
  std::set<uint32_t> levels;
  std::vector<double> first, now;
  for (int i = 0; i < 80; ++i) {
    const Geodetic at = Geodetic::from_degrees(10.0, 11.0, 1500.0 + 20e3 * std::pow(step, i));
    const TerrainView view = view_at(at, Attitude::from_degrees(0.0, -90.0), 60.0, {640, 360});
    const std::vector<SelectedTile> tiles = select_tiles(view, world.metas);
    for (const SelectedTile& s : tiles) levels.insert(s.tile.level);
    const RayCaster caster(view.camera_ecef_m, tiles, [&](const SelectedTile& s) {
      return drawn_positions(s, tile_vertices(s.tile, world.ground, Ellipsoid::wgs84()));
    });
    now.clear();
    for (int k = 0; k < 20; ++k) {
      // Places on the ground that stay in the picture: the height where the vertical through them meets the surface,
      // found by the ray from the camera through their place on the ellipsoid.
      const double angle = 2.4 * k, away_m = 60.0 * std::sqrt(k + 1.0);
      const Geodetic place = Geodetic::from_degrees(10.0 + away_m * std::sin(angle) / 111e3,
                                                    11.0 + away_m * std::cos(angle) / 111e3, 500.0);
      const dvec3 up = geodetic_up_ecef(place.lat_rad, place.lon_rad);
      double low = -3000.0, high = 3000.0;  // the surface is a function of the place: bisect along the vertical
      for (int n = 0; n < 24; ++n) {
        const double middle = 0.5 * (low + high);
        const dvec3 to = ecef_from_geodetic(place) + middle * up - view.camera_ecef_m;
        const auto hit = caster.first_hit(glm::normalize(to));
        REQUIRE(hit);
        (hit->distance_m < glm::length(to) ? low : high) = middle;
      }
      now.push_back(0.5 * (low + high));
    }
    const double px_m = view.pixel_angle_rad * (at.height_m - 1500.0);
    if (i == 0) first = now;
    for (size_t k = 0; k < before.size(); ++k) worst_px = std::max(worst_px, std::abs(now[k] - before[k]) / px_m);
    before = now;
  }
  double moved_px = 0.0;
  for (size_t k = 0; k < now.size(); ++k) moved_px = std::max(moved_px, std::abs(now[k] - first[k]) / 3.0);
  MESSAGE("largest move in a step " << worst_px << " px, over all " << moved_px << " px of 3 m; levels "
                                    << levels.size());
  CHECK(worst_px < 0.3);
  CHECK(moved_px > 3.0);
  CHECK(levels.size() >= 3);
}

TEST_CASE("no selected tile exceeds the screen error that was asked for") {
  World world({rough_world()});
  for (const Camera& c : kCameras) {
    const TerrainView view = view_at(Geodetic::from_degrees(c.lat, c.lon, c.height),
                                     Attitude::from_degrees(c.heading, c.pitch), c.fov, {640, 360});
    for (const SelectedTile& s : select_tiles(view, world.metas)) {
      if (s.tile.level == kMaxTerrainLevel || !may_split(s.tile)) continue;
      const double px = world.metas.meta(s.tile).error_m / std::max(0.5, s.distance_m) / view.pixel_angle_rad;
      REQUIRE(px <= view.screen_error_px);
    }
  }
}

TEST_CASE("a tile's box and height range hold its surface at every finer level") {
  World world({rough_world()});
  std::mt19937 random(3);
  for (const TileId tile :
       {TileId{0, 1, 0}, TileId{2, 5, 1}, TileId{5, 40, 12}, TileId{9, 700, 0}, TileId{12, 1, 2047}}) {
    const TileMeta meta = world.builder.make_meta(tile);
    const TileBounds b = tile_bounds(tile);
    std::uniform_real_distribution<double> lat(b.south_deg, b.north_deg), lon(b.west_deg, b.east_deg);
    for (int i = 0; i < 500; ++i) {
      Geodetic g = Geodetic::from_degrees(lat(random), lon(random));
      g.height_m = world.ground.height_m(g.lat_rad, g.lon_rad, tile.level + static_cast<uint32_t>(i % 2));
      REQUIRE(g.height_m >= meta.heights.min_m);
      REQUIRE(g.height_m <= meta.heights.max_m);
      REQUIRE(meta.volume.distance_m(ecef_from_geodetic(g)) == 0.0);
    }
  }
}

TEST_CASE("the horizon hides the far side of the Earth and nothing in front of it") {
  const Geodetic at = Geodetic::from_degrees(0.0, 0.0, 1000.0);
  TerrainView view = view_at(at, Attitude::from_degrees(90.0, 0.0), 60.0, {640, 360});
  view.deepest_land_m = 0.0;
  const double horizon_deg =
      deg_from_rad(std::acos(6378137.0 / (6378137.0 + 1000.0)));  // 1.01 degrees along the equator
  const auto volume = [](double lon) { return make_tile_volume(tile_at(12, 0.01, lon), 0.0, 0.0, {}); };
  CHECK(!below_horizon(volume(horizon_deg - 0.1), view));
  CHECK(below_horizon(volume(horizon_deg + 0.1), view));
  CHECK(below_horizon(volume(179.0), view));
  // A mountain of 1000 m shows over the horizon up to twice that far.
  const auto mountain = [](double lon) { return make_tile_volume(tile_at(12, 0.01, lon), 0.0, 1000.0, {}); };
  CHECK(!below_horizon(mountain(2.0 * horizon_deg - 0.1), view));
  CHECK(below_horizon(mountain(2.0 * horizon_deg + 0.1), view));
  CHECK(outside_frustum(volume(-0.5), view));  // behind the camera
  CHECK(!outside_frustum(volume(0.5), view));
}
