#include <doctest/doctest.h>

#include "geo/region_map.h"
#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "gpu/pipeline.h"
#include "terrain/terrain_shadow_map.h"
#include "terrain/test_terrain_shadow.comp.h"
#include "terrain/test_terrain_volume.comp.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;
using glm::vec4;

namespace {

constexpr double kA = 6378137.0;       // the equator's radius
constexpr double kDisc_rad = 0.00465;  // radius of the sun's disc
constexpr double kWall_m = 1000.0;
constexpr double kWallThick_deg = 0.045;
constexpr double kWallFrom_deg = 20.1;  // its western face; it stands on the equator, the sun is in the east

struct Rig {
  GpuFixture gpu;
  gpu::ComputePipeline pipeline{gpu.device, {.name = "test.terrain_shadow", .spirv = test_terrain_shadow_comp}};
  gpu::ComputePipeline volume_pipeline{gpu.device, {.name = "test.terrain_volume", .spirv = test_terrain_volume_comp}};
  TerrainShadowMap map{gpu.device};
  FrameInfo frame;

  /// A camera on the equator, and a light `elevation_rad` above its eastern horizon.
  void look(double lon_deg, double elevation_rad, double height_m = 2.0) {
    const Geodetic at = Geodetic::from_degrees(0.0, lon_deg, height_m);
    frame = frame_at(at, {}, 60.0, {64, 64});
    const dvec3 up = geodetic_up_ecef(at.lat_rad, at.lon_rad), east(-std::sin(at.lon_rad), std::cos(at.lon_rad), 0.0);
    frame.constants.key_dir = vec3(std::sin(elevation_rad) * up + std::cos(elevation_rad) * east);
    frame.constants.camera_up = vec3(up);
    frame.constants.sun_angular_radius_rad = static_cast<float>(kDisc_rad);
  }

  /// `by_map`: by the map of shadow heights, for the air; else by the march. `sequence`: the map may lag behind the
  /// light.
  std::vector<double> shares(const std::vector<Geodetic>& places, bool by_map = false, bool sequence = false) {
    std::vector<vec4> points;
    for (const Geodetic& p : places) points.push_back(vec4(vec3(ecef_from_geodetic(p) - frame.camera_ecef_m), 0.0f));
    FrameGraph graph;
    const BufferRef out = graph.create_buffer("shares", points.size() * sizeof(float));
    frame.buffer = graph.constants("frame", frame.constants);
    const TerrainVolumeRefs volume = by_map ? map.add_volume(graph, frame, sequence) : TerrainVolumeRefs{};
    auto pass = graph.pass("test.terrain_shadow");
    pass.uniform("frame", frame.buffer).read("points", graph.constants("points", points)).write("shares", out);
    if (by_map)
      bind_terrain_volume(pass, volume);
    else
      bind_terrain_shadow(pass, map.import_into(graph));
    pass.record([&](gpu::Commands& cmd) {
      cmd.bind(by_map ? volume_pipeline : pipeline).dispatch_threads(static_cast<uint32_t>(points.size()));
    });
    graph.keep(out);
    gpu.executor.run(graph);
    const std::vector<float> read = gpu.executor.read<float>(out);
    return {read.begin(), read.end()};
  }
};

/// Level ground with a wall along a meridian, 5 km thick.
std::shared_ptr<ArrayRaster> wall() {
  return raster_of(
      2000, 100, {.west_deg = 19.8, .south_deg = -0.1, .east_deg = 20.3, .north_deg = 0.1},
      [](double, double lon) { return lon > kWallFrom_deg && lon < kWallFrom_deg + kWallThick_deg ? kWall_m : 0.0; },
      VerticalDatum::ellipsoid);
}

/// The angle at the Earth's centre from the foot of the wall to where its top appears `elevation_rad` above the
/// horizontal: (a + H) cos(angle + elevation) = a cos(elevation).
double shadow_angle(double elevation_rad) {
  return std::acos(kA * std::cos(elevation_rad) / (kA + kWall_m)) - elevation_rad;
}

/// Where along the line of places the share passes `value`, by straight lines between them; shares rise westwards.
double crossing(const std::vector<double>& at, const std::vector<double>& shares, double value) {
  for (size_t i = 1; i < at.size(); ++i)
    if (shares[i - 1] < value && shares[i] >= value)
      return at[i - 1] + (at[i] - at[i - 1]) * (value - shares[i - 1]) / (shares[i] - shares[i - 1]);
  return -1.0;
}

double texel_at(const shared::RegionMap& map, double away_m) {
  double half_m = static_cast<double>(map.half_m);
  while (half_m < away_m) half_m *= 2.0;
  return 2.0 * half_m / shared::kShadowTexels;
}

}  // namespace

TEST_CASE(
    "gpu: a wall's shadow ends where the Earth's curve lets it, within a texel, and its penumbra is as wide as the "
    "disc") {
  Rig rig;
  const HeightSampler heights({wall()}, false, nullptr);
  for (const double elevation_deg : {2.0, 3.0, 5.0, 10.0}) {
    CAPTURE(elevation_deg);
    const double e = rad_from_deg(elevation_deg), tip = shadow_angle(e);
    const double tip_lon_deg = kWallFrom_deg - deg_from_rad(tip);
    rig.look(tip_lon_deg, e);
    rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 6));
    // Along the equator about the tip; x is metres west of the wall.
    std::vector<double> x;
    std::vector<Geodetic> places;
    for (double f = 0.7; f < 1.4; f += 0.002) {
      x.push_back(kA * tip * f);
      places.push_back(Geodetic::from_degrees(0.0, kWallFrom_deg - deg_from_rad(tip * f)));
    }
    const std::vector<double> shares = rig.shares(places);
    const double texel_m = texel_at(rig.map.constants().map, kA * tip);
    CAPTURE(texel_m);
    CHECK(std::abs(crossing(x, shares, 0.5) - kA * tip) < texel_m);
    // The light's elevation falls westwards by the angle gone; the wall's top is half a radius of the disc above or
    // below it where shadow_angle(e - (angle - tip) +- radius / 2) = angle, solved by iteration.
    const auto edge = [&](double radii) {
      double angle = tip;
      for (int i = 0; i < 50; ++i) angle = shadow_angle(e - (angle - tip) - radii * kDisc_rad);
      return kA * angle;
    };
    const double whole = edge(0.5) - edge(-0.5);
    const double third = static_cast<double>(shared::disc_share(-0.5f)),
                 most = static_cast<double>(shared::disc_share(0.5f));
    CHECK(std::abs(crossing(x, shares, most) - crossing(x, shares, third) - whole) < 0.4 * texel_m);
    CHECK(shares.front() == 0.0);
    CHECK(shares.back() == 1.0);
  }
}

TEST_CASE("gpu: above the ground a shadow is as high as the line from the light over the wall") {
  Rig rig;
  const HeightSampler heights({wall()}, false, nullptr);
  const double e = rad_from_deg(1.5), angle = 8e3 / kA;  // 8 km west of the wall
  const double lon_deg = kWallFrom_deg - deg_from_rad(angle);
  rig.look(lon_deg, e);
  rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 6));
  // (a + H) cos(angle + e) = (a + h) cos(e)
  const double top_m = (kA + kWall_m) * std::cos(angle + e) / std::cos(e) - kA;
  std::vector<double> h;
  std::vector<Geodetic> places;
  for (double m = 600.0; m < 1000.0; m += 4.0) {
    h.push_back(m);
    places.push_back(Geodetic::from_degrees(0.0, lon_deg, m));
  }
  const double texel_m = texel_at(rig.map.constants().map, 8.1e3);
  CHECK(std::abs(crossing(h, rig.shares(places), 0.5) - top_m) < texel_m * std::tan(e) + 0.5);
}

TEST_CASE(
    "gpu: the map of shadow heights has a wall's shadow in the air where the round Earth puts it, and the disc's "
    "penumbra") {
  Rig rig;
  const HeightSampler heights({wall()}, false, nullptr);
  for (const double elevation_deg : {-0.3, 0.5, 1.5, 4.0})
    for (const double away_m : {4e3, 8e3, 25e3}) {
      CAPTURE(elevation_deg);
      CAPTURE(away_m);
      const double e = rad_from_deg(elevation_deg), angle = away_m / kA;
      const double lon_deg = kWallFrom_deg - deg_from_rad(angle);
      rig.look(lon_deg, e);
      rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 6));
      // (a + H) cos(angle + e) = (a + h) cos(e), for the light's centre and edges; by the wall's far edge where the
      // light comes from below.
      const double edge = e + angle < 0.0 ? angle + rad_from_deg(kWallThick_deg) : angle;
      const auto height = [&](double radii) {
        const double lower = e + radii * kDisc_rad;
        return (kA + kWall_m) * std::cos(edge + lower) / std::cos(lower) - kA;
      };
      if (height(1.0) < 20.0) continue;  // it has ended before
      std::vector<double> h;
      std::vector<Geodetic> places;
      for (double m = 2.0; m < height(-1.0) + 200.0; m += 1.0) {
        h.push_back(m);
        places.push_back(Geodetic::from_degrees(0.0, lon_deg, m));
      }
      const std::vector<double> shares = rig.shares(places, true);
      const double texel_m = texel_at(rig.map.constants().map, 1.02 * kA * edge);
      const double tolerance_m = texel_m * std::tan(std::abs(e) + edge) + 1.0;
      CHECK(std::abs(crossing(h, shares, 0.5) - height(0.0)) < tolerance_m);
      const double third = static_cast<double>(shared::disc_share(-0.5f)),
                   most = static_cast<double>(shared::disc_share(0.5f));
      CHECK(crossing(h, shares, most) - crossing(h, shares, third) ==
            doctest::Approx(height(-0.5) - height(0.5)).epsilon(0.05).scale(1.0));
      CHECK(shares.front() == (height(1.0) > 30.0 ? doctest::Approx(0.0) : doctest::Approx(0.0).epsilon(0.2)));
      CHECK(shares.back() == 1.0);
    }
}

TEST_CASE("gpu: in the air over hills the map of shadow heights says what the march says") {
  Rig rig;
  // Ridges across the light, 400 to 1200 m high, with gaps.
  const auto hills = raster_of(
      1500, 600, {.west_deg = 19.8, .south_deg = -0.1, .east_deg = 20.3, .north_deg = 0.1},
      [](double lat, double lon) {
        return 800.0 + 300.0 * std::sin(lon * 400.0) * std::cos(lat * 300.0) + 100.0 * std::sin(lat * 900.0);
      },
      VerticalDatum::ellipsoid);
  const HeightSampler heights({hills}, false, nullptr);
  for (const double elevation_deg : {1.0, 4.0, 12.0}) {
    CAPTURE(elevation_deg);
    rig.look(20.05, rad_from_deg(elevation_deg), 1500.0);
    rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 6));
    std::vector<Geodetic> places;
    for (double lat = -0.05; lat < 0.05; lat += 0.003)
      for (double lon = 19.95; lon < 20.15; lon += 0.004)
        for (double h = 1230.0; h < 1600.0; h += 40.0) places.push_back(Geodetic::from_degrees(lat, lon, h));
    for (double lat = -0.05; lat < 0.05; lat += 0.003)
      for (double lon = 19.95; lon < 20.15; lon += 0.004)
        for (double over_m = 30.0; over_m < 400.0; over_m += 40.0) {
          const double ground_m = heights.height_m(rad_from_deg(lat), rad_from_deg(lon), 14);
          places.push_back(Geodetic::from_degrees(lat, lon, ground_m + over_m));
        }
    const std::vector<double> by_march = rig.shares(places), by_map = rig.shares(places, true);
    double off = 0.0, shaded = 0.0;
    for (size_t i = 0; i < places.size(); ++i) {
      off += std::abs(by_map[i] - by_march[i]);
      shaded += 1.0 - by_march[i];
    }
    MESSAGE("mean difference ", off / static_cast<double>(places.size()), ", mean shade ",
            shaded / static_cast<double>(places.size()));
    REQUIRE(shaded > 0.02 * static_cast<double>(places.size()));
    CHECK(off < 0.01 * static_cast<double>(places.size()));
  }
}

TEST_CASE("gpu: in a sequence the map of shadow heights follows the light in steps, level by level; else at once") {
  Rig rig;
  const HeightSampler heights({wall()}, false, nullptr);
  constexpr uint32_t kLevels = 6;
  constexpr double kLow_rad = 0.03;
  std::vector<Geodetic> places;
  for (double away_m = 1e3; away_m < 30e3; away_m *= 1.5)
    for (double h = 2.0; h < 1000.0; h += 50.0)
      places.push_back(Geodetic::from_degrees(0.0, kWallFrom_deg - deg_from_rad(away_m / kA), h));
  rig.look(20.0, kLow_rad);
  const shared::RegionMap map = make_region_map(rig.frame.camera_ecef_m, 2e3, kLevels);
  rig.map.update(heights, map);
  const auto at = [&](double elevation_rad, bool sequence) {
    rig.look(20.0, elevation_rad);
    return rig.shares(places, true, sequence);
  };
  const std::vector<double> low = at(kLow_rad, false), high = at(kLow_rad + 2e-3, false);
  REQUIRE(low != high);
  REQUIRE(at(kLow_rad, false) == low);
  CHECK(at(kLow_rad + 0.8e-3, true) == low);
  const std::vector<double> first = at(kLow_rad + 2e-3, true);
  CHECK(first != high);
  for (uint32_t level = 1; level + 1 < kLevels; ++level) at(kLow_rad + 2e-3, true);
  CHECK(at(kLow_rad + 2e-3, true) == high);
  CHECK(at(kLow_rad + 1e-2, true) == at(kLow_rad + 1e-2, false));  // as after a cut
}

TEST_CASE("gpu: smooth ground shades no air") {
  Rig rig;
  const HeightSampler heights({}, false, nullptr);
  for (const double elevation_deg : {-0.5, 0.2, 0.5, 3.0, 45.0}) {
    CAPTURE(elevation_deg);
    rig.look(20.0, rad_from_deg(elevation_deg));
    rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 8));
    std::vector<Geodetic> places;
    for (double away_m = 0.0; away_m < 2e5; away_m = away_m * 1.6 + 3.0)
      for (const double height_m : {1.0, 30.0, 1e3, 9e3})
        places.push_back(Geodetic::from_degrees(0.01, 20.0 + deg_from_rad(away_m / kA), height_m));
    for (const double share : rig.shares(places, true)) CHECK(share >= 0.99);
  }
}

TEST_CASE("gpu: smooth ground shades nothing, from a light 0.2 degrees above the horizon to one overhead") {
  Rig rig;
  const HeightSampler heights({}, false, nullptr);
  for (const double elevation_deg : {0.2, 0.3, 0.5, 1.0, 3.0, 10.0, 45.0, 90.0})
    for (const double lon_deg : {-30.0, 20.0, 179.99}) {
      CAPTURE(elevation_deg);
      rig.look(lon_deg, rad_from_deg(elevation_deg));
      rig.map.update(heights, make_region_map(rig.frame.camera_ecef_m, 2e3, 8));
      std::vector<Geodetic> places;
      // East of the camera the light is higher.
      for (double away_m = 0.0; away_m < 2e5; away_m = away_m * 1.6 + 3.0)
        for (const double lat_deg : {0.0, 0.01, -0.2})
          places.push_back(Geodetic::from_degrees(lat_deg, lon_deg + deg_from_rad(away_m / kA)));
      for (const double share : rig.shares(places)) REQUIRE(share >= 0.999);
    }
}

TEST_CASE("gpu: the shadow map is wanted only where ground is uneven and the light low") {
  Rig rig;
  const HeightSampler even({}, false, nullptr), uneven({wall()}, false, nullptr);
  rig.look(20.0, 0.1);
  CHECK(rig.map.update(uneven, rig.frame));
  CHECK(rig.map.constants().highest_m == doctest::Approx(kWall_m));
  CHECK_FALSE(rig.map.update(even, rig.frame));
  rig.look(20.0, 1.2);
  CHECK_FALSE(rig.map.update(uneven, rig.frame));
  rig.look(20.0, -0.2);
  CHECK_FALSE(rig.map.update(uneven, rig.frame));
  rig.look(20.0, 1.2, 400e3);
  CHECK(rig.map.update(uneven, rig.frame));
}
