// No view of the ground shows what is behind it. Passes of the terrain alone; small pictures of many views.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/gtc/packing.hpp>

#include "gpu/gpu_fixture.h"
#include "terrain/surface_query.h"
#include "terrain/terrain.h"
#include "terrain_draw.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr float kSky = 1.0e10f;

bool full_test() {
  const char* full = std::getenv("NEPHO_TEST_FULL");
  return full && std::string(full) == "1";
}

class Random {
 public:
  double operator()(double low, double high) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  uint64_t state_ = 2026;
};

struct View {
  Geodetic at;  // height above the ground
  Attitude attitude;
  double fov_deg = 45.0;
};

/// Views of all kinds in turn: anywhere, near a pole, on the antimeridian, grazing the ground, just where levels
/// change.
View random_view(Random& random, int i) {
  View v;
  const double agl_m = 2.0 * std::pow(2e7, random(0.0, 1.0));  // 2 m to 40,000 km, evenly in its logarithm
  double lat = deg_from_rad(std::asin(random(-1.0, 1.0))), lon = random(-180.0, 180.0);
  const double horizon_deg = -deg_from_rad(std::acos(6371e3 / (6371e3 + agl_m)));
  double pitch = random(-90.0, horizon_deg + 10.0);
  switch (i % 5) {
    case 1:
      lat = std::copysign(90.0 - std::pow(10.0, random(-6.0, 1.0)), random(-1.0, 1.0));
      break;
    case 2:
      lon = 180.0 + std::copysign(std::pow(10.0, random(-7.0, 0.5)), random(-1.0, 1.0));
      break;
    case 3:
      pitch = horizon_deg + random(-4.0, 1.0);
      break;
    case 4:
      lat = std::round(lat / 5.625) * 5.625;  // where four tiles meet, of all levels from 5 on
      lon = std::round(lon / 5.625) * 5.625;
      break;
    default:
      break;
  }
  if (i % 40 == 7) lat = i % 80 == 7 ? 90.0 : -90.0;
  v.at = Geodetic::from_degrees(lat, lon, agl_m);
  v.attitude = Attitude::from_degrees(random(0.0, 360.0), pitch, random(-30.0, 30.0));
  v.fov_deg = random(0.0, 1.0) < 0.2 ? random(0.5, 20.0) : random(30.0, 90.0);
  return v;
}

}  // namespace

TEST_CASE("gpu: watertight: no view of rough ground shows sky or a bad number inside the globe's silhouette") {
  // Mountains at every pixel of 55 km, seas between them, and an inset of 100 m pixels, so that levels meet.
  constexpr double kHighest_m = 4000.0;
  uint32_t state = 99;
  const auto rough = [&state](double, double) {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / 16777216.0 * (kHighest_m + 1500.0) - 1500.0;
  };
  const LonLatBounds inset{7.0, 46.0, 7.25, 46.25};
  GpuFixture gpu;
  TerrainSources sources;
  sources.elevation = {raster_of(720, 360, {}, rough), raster_of(250, 250, inset, rough)};
  sources.has_default = true;  // below 0 is sea, at 0
  Terrain terrain(gpu.device, std::move(sources), {});
  const bool full = full_test();
  const int views = full ? 200 : 40;
  const Extent2D extent = full ? Extent2D{160, 90} : Extent2D{96, 54};
  Random random;
  size_t inside = 0, holes = 0, bad = 0, too_far_out = 0, seen = 0;
  for (int i = 0; i < views; ++i) {
    View v = random_view(random, full ? i : i * 5 + i % 5);
    if (i % 8 == 5)
      v.at = Geodetic::from_degrees(random(45.99, 46.26), random(6.99, 7.26), 2.0 * std::pow(1e4, random(0, 1)));
    v.at.height_m += surface_height_m(terrain.heights(), v.at.lat_rad, v.at.lon_rad);
    CAPTURE(i);
    CAPTURE(v.at.lat_deg());
    CAPTURE(v.at.lon_deg());
    CAPTURE(v.at.height_m);
    CAPTURE(deg_from_rad(v.attitude.pitch_rad));
    const FrameInfo frame = frame_at(v.at, v.attitude, v.fov_deg, extent, glm::vec2(0.25f, -0.35f));
    const DrawnTerrain drawn = draw_terrain(gpu, terrain, frame);
    size_t view_holes = 0, view_inside = 0;
    for (uint32_t y = 0; y < extent.height; ++y)
      for (uint32_t x = 0; x < extent.width; ++x) {
        const size_t p = size_t{y} * extent.width + x;
        const float depth = drawn.depth_m[p];
        const dvec3 ray = pixel_ray(frame, x + 0.5, y + 0.5);
        bool finite = std::isfinite(depth) && depth > 0.0f;
        for (size_t b = 0; b < 4 && depth < kSky; ++b)
          finite &= std::isfinite(glm::unpackHalf1x16(drawn.albedo[4 * p + b])) &&
                    std::isfinite(glm::unpackHalf1x16(drawn.normal[4 * p + b]));
        bad += !finite;
        // The deepest ground is the sea; a cell's middle may lie lower by its sagitta, a pixel's share or 100 m.
        const double sag_m = std::min(100.0, static_cast<double>(frame.constants.pixel_angle_rad) * v.at.height_m);
        if (hit_ellipsoid(frame.camera_ecef_m, ray, -sag_m) > 0.0) {
          ++view_inside;
          view_holes += depth == kSky;
        } else if (depth < kSky) {
          too_far_out += hit_ellipsoid(frame.camera_ecef_m, ray, 1.1 * kHighest_m) < 0.0;
        }
      }
    CHECK(view_holes == 0);
    inside += view_inside;
    holes += view_holes;
    seen += view_inside > 0;
  }
  MESSAGE(views << " views, " << seen << " of them see the globe, " << inside << " pixels inside it");
  CHECK(holes == 0);
  CHECK(bad == 0);
  CHECK(too_far_out == 0);
  CHECK(seen > static_cast<size_t>(views) * 3 / 4);
}

TEST_CASE("gpu: with elevation off the silhouette is the ellipsoid's to half a pixel, from 100 km to 40,000 km") {
  GpuFixture gpu;
  Terrain terrain(gpu.device, {}, {});
  const bool full = full_test();
  const Extent2D extent{240, 135};
  Random random;
  double worst_px = 0.0;
  size_t crossings = 0;
  for (int i = 0; i < (full ? 60 : 15); ++i) {
    const double height_m = 1e5 * std::pow(400.0, random(0.0, 1.0));
    const double horizon_deg = -deg_from_rad(std::acos(6371e3 / (6371e3 + height_m)));
    const FrameInfo frame =
        frame_at(Geodetic::from_degrees(deg_from_rad(std::asin(random(-1.0, 1.0))), random(-180.0, 180.0), height_m),
                 Attitude::from_degrees(random(0.0, 360.0), horizon_deg + random(-3.0, 3.0), random(-90.0, 90.0)),
                 random(5.0, 45.0), extent);
    CAPTURE(height_m);
    const std::vector<float> depth = draw_terrain(gpu, terrain, frame).depth_m;
    // Along every row: where the picture changes between ground and sky, the exact silhouette is found by bisection.
    const auto hits = [&](double x, double y) {
      return hit_ellipsoid(frame.camera_ecef_m, pixel_ray(frame, x, y)) > 0.0;
    };
    for (uint32_t y = 0; y < extent.height; ++y)
      for (uint32_t x = 0; x < extent.width; ++x) {
        const bool ground = depth[size_t{y} * extent.width + x] < kSky;
        if (ground == hits(x + 0.5, y + 0.5)) continue;
        // A pixel of the wrong kind: how far is the silhouette from its centre?
        double nearest = 9.0;
        for (int a = 0; a < 32; ++a) {
          const double c = std::cos(a * std::numbers::pi / 16), s = std::sin(a * std::numbers::pi / 16);
          double r = 0.0;
          while (r < nearest && hits(x + 0.5 + r * c, y + 0.5 + r * s) != ground) r += 0.02;
          nearest = std::min(nearest, r);
        }
        worst_px = std::max(worst_px, nearest);
        ++crossings;
        CHECK(nearest <= 0.52);  // half a pixel, and this search's step
      }
  }
  MESSAGE(crossings << " pixels are of the wrong kind; the silhouette is " << worst_px << " px off at most");
}
