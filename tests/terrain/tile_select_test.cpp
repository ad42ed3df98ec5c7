#include "terrain/tile_select.h"

#include <doctest/doctest.h>

#include <random>
#include <set>

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
