// The drawn surface near a camera against the DEM that it was made from, as GDAL reads it.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <unordered_map>

#include "geo/geoid.h"
#include "gpu/gpu_fixture.h"
#include "rasters/gdal_opener.h"
#include "render/gdal_truth.h"
#include "render/shared_data.h"
#include "terrain/ground_picker.h"
#include "terrain/surface_query.h"
#include "terrain_draw.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr Extent2D kExtent{192, 108};
constexpr double kLag = 0.25;  ///< px

struct Point {
  double lat_deg, lon_deg;
  double msl_m;    // as drawn
  double error_m;  // that its level promises
};

/// 1,000 random pixels of views all around a place.
std::vector<Point> points_around(GpuFixture& gpu, Terrain& terrain, double lat_deg, double lon_deg) {
  std::vector<Point> points;
  uint32_t state = 5;
  const auto random = [&state](uint32_t n) {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % n;
  };
  Geodetic at = Geodetic::from_degrees(lat_deg, lon_deg);
  at.height_m = surface_height_m(terrain.heights(), at.lat_rad, at.lon_rad) + 800.0;
  std::unordered_map<TileId, double> errors;
  for (int view = 0; view < 4; ++view) {
    const FrameInfo frame = frame_at(at, Attitude::from_degrees(45.0 + 90.0 * view, -40.0), 60.0, kExtent);
    const std::vector<float> depth = draw_terrain(gpu, terrain, frame).depth_m;
    const GroundPicker picker(terrain, frame);
    for (int i = 0; i < 250;) {
      const uint32_t x = random(kExtent.width), y = random(kExtent.height);
      const auto t = static_cast<double>(depth[size_t{y} * kExtent.width + x]);
      const std::optional<GroundHit> hit = picker.at(x + 0.5, y + 0.5);
      if (t > 5000.0 || !hit) continue;
      ++i;
      const Geodetic p = geodetic_from_ecef(frame.camera_ecef_m + t * pixel_ray(frame, x + 0.5, y + 0.5));
      if (!errors.contains(hit->tile)) errors[hit->tile] = terrain.error_m(hit->tile);
      points.push_back({p.lat_deg(), p.lon_deg(), p.height_m - Geoid::egm96().undulation_m(p.lat_rad, p.lon_rad),
                        errors.at(hit->tile)});
    }
  }
  return points;
}

/// The place with the most relief around it of those without voids, far from the raster's edge.
std::array<double, 2> steepest(const GdalTruth& dem) {
  constexpr int kReach = 70, kStep = 60;
  std::array<double, 2> best{};
  double most_m = 0.0;
  for (int y = kReach + 20; y < dem.height() - kReach - 20; y += kStep)
    for (int x = kReach + 20; x < dem.width() - kReach - 20; x += kStep) {
      const std::array<double, 2> at = dem.place_of(x + 0.5, y + 0.5);
      const auto range = dem.around(at[0], at[1], 1, kReach);
      if (!range || range->high - range->low <= most_m) continue;
      most_m = range->high - range->low;
      best = at;
    }
  return best;
}

/// Correlation of the drawn heights with the DEM's some pixels beside them.
double correlation(GdalTruth& dem, const std::vector<Point>& points, double dx, double dy) {
  double n = 0.0, a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (const Point& p : points) {
    const std::optional<double> h = dem.bilinear(p.lat_deg, p.lon_deg, dx, dy);
    if (!h) continue;
    n += 1.0;
    a += p.msl_m;
    b += *h;
    aa += p.msl_m * p.msl_m;
    bb += *h * *h;
    ab += p.msl_m * *h;
  }
  return (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
}

/// Where a parabola through the values at -1, 0 and 1 peaks.
double peak(double before, double at, double after) { return 0.5 * (before - after) / (before - 2.0 * at + after); }

}  // namespace

TEST_CASE(
    "gpu: the drawn surface near a camera is the DEM's within half the error that its level promises, unshifted") {
  GpuFixture gpu;
  for (const std::string file : {"dem/mt_fuji_90m.tif", "dem/N46E008_swiss_alps.tif", "dem/N42E001.hgt"}) {
    CAPTURE(file);
    const std::string path = shared_data(file);
    if (path.empty()) continue;
    GdalTruth dem(path);
    REQUIRE(dem.good());
    TerrainSources sources;
    sources.elevation = {make_gdal_opener()->open_elevation(path)};
    sources.geoid = std::make_shared<const Geoid>(Geoid::egm96());
    Terrain terrain(gpu.device, std::move(sources), {});
    const std::array<double, 2> place = steepest(dem);
    std::vector<Point> points = points_around(gpu, terrain, place[0], place[1]);
    // A void's rim is drawn down to what lies below.
    std::erase_if(points, [&](const Point& p) { return !dem.around(p.lat_deg, p.lon_deg, 1, 2); });
    double squares = 0.0, shares = 0.0, errors = 0.0, n = 0.0, lowest = 1e9, highest = -1e9;
    for (const Point& p : points) {
      const std::optional<double> h = dem.bilinear(p.lat_deg, p.lon_deg);
      const double off = p.msl_m - *h;
      squares += off * off;
      shares += off * off / (p.error_m * p.error_m);
      errors += p.error_m * p.error_m;
      lowest = std::min(lowest, *h);
      highest = std::max(highest, *h);
      n += 1.0;
    }
    REQUIRE(n > 800.0);
    const double rms_m = std::sqrt(squares / n), promised_m = std::sqrt(errors / n), share = std::sqrt(shares / n);
    const double centre = correlation(dem, points, 0.0, 0.0);
    const double east = kLag * peak(correlation(dem, points, -kLag, 0.0), centre, correlation(dem, points, kLag, 0.0));
    const double south = kLag * peak(correlation(dem, points, 0.0, -kLag), centre, correlation(dem, points, 0.0, kLag));
    for (int k = 0; k < 9; ++k)
      if (k != 4) CHECK(correlation(dem, points, k % 3 - 1.0, k / 3 - 1.0) < centre);
    MESSAGE(file << ": " << n << " points from " << lowest << " to " << highest << " m, off by " << rms_m
                 << " m RMS where the levels promise " << promised_m << " m (" << share
                 << " of each point's own); shifted by " << east << " pixels to the east, " << south
                 << " to the south");
    CHECK(rms_m <= 0.5 * promised_m);
    CHECK(share <= 0.5);
    CHECK(highest - lowest > 300.0);
    CHECK(centre > 0.999);
    // A shift of 0.05 pixels, 4.6 m, would be 2 m of height on these slopes.
    CHECK(std::abs(east) < 0.05);
    CHECK(std::abs(south) < 0.05);
  }
}
