#include "terrain/height_sampler.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "terrain/imagery_sampler.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {
double height_deg(const HeightSampler& s, double lat, double lon, uint32_t level = kMaxTileLevel) {
  return s.height_m(rad_from_deg(lat), rad_from_deg(lon), level);
}
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
}  // namespace

TEST_CASE("without rasters the surface is the ellipsoid, with or without a geoid") {
  const HeightSampler plain({}, false, nullptr);
  CHECK(height_deg(plain, 12.3, 45.6) == 0.0);
  const HeightSampler with_geoid({}, false, std::make_shared<Geoid>(Geoid::find_egm96()));
  CHECK(height_deg(with_geoid, 12.3, 45.6) == 0.0);
}

TEST_CASE("a plane comes back exactly between pixel centres, at the place it was put") {
  const auto plane = [](double lat, double lon) { return 1000.0 + 64.0 * lat - 32.0 * lon; };
  const HeightSampler s({raster_of(64, 64, {10.0, 20.0, 12.0, 22.0}, plane)}, false, nullptr);
  for (const auto& [lat, lon] : {std::pair{21.0, 11.0}, {20.3, 10.7}, {21.97, 11.98}, {20.02, 10.02}})
    CHECK(height_deg(s, lat, lon) == doctest::Approx(plane(lat, lon)).epsilon(1e-9));
}

TEST_CASE("coarse levels see the mean of the pixels between their vertices") {
  // Columns alternate 0 and 200 m; level 0 has vertices 2.8125 degrees apart, 9 of these pixels.
  const HeightSampler s({raster_of(1152, 576, {},
                                   [](double, double lon) {
                                     return std::fmod(std::floor((lon + 180.0) / 0.3125), 2.0) == 0.0 ? 0.5 : 200.5;
                                   })},
                        false, nullptr);
  CHECK(height_deg(s, 0.4, 0.7, 0) == doctest::Approx(100.5));
  CHECK(height_deg(s, 0.4, 0.15625) == doctest::Approx(0.5));
  CHECK(height_deg(s, 0.4, 0.46875) == doctest::Approx(200.5));
}

TEST_CASE("the outside of a raster shows what lies below, blended within a pixel; a hole has the height of its rim") {
  const auto below = raster_of(360, 180, {}, [](double, double) { return 100.0; });
  const auto above = raster_of(16, 16, {0.0, 0.0, 16.0, 16.0}, [](double lat, double lon) {
    return lat > 8.0 && lat < 9.0 && lon > 8.0 && lon < 9.0 ? kNan : 300.0;
  });
  const HeightSampler s({below, above}, false, nullptr);
  CHECK(height_deg(s, 4.5, 4.5) == 300.0);
  CHECK(height_deg(s, 8.5, 8.5) == doctest::Approx(300.0));
  CHECK(height_deg(s, 8.5, 9.0) == doctest::Approx(300.0));
  CHECK(height_deg(s, 4.5, 16.0) == doctest::Approx(200.0));
  CHECK(height_deg(s, 4.5, 17.0) == 100.0);
  CHECK(height_deg(s, 4.5, -1.0) == 100.0);
  CHECK(height_deg(s, 4.5, 0.0) == doctest::Approx(200.0));
}

TEST_CASE("voids keep the shapes of what lies below, lifted to their rim; large ones sink back to it") {
  // Below: hills, all 700 m too low. Above: the truth, with a hole of 6 x 6 pixels and one of 306 x 306.
  const auto hills = [](double lat, double lon) { return 1000.0 + 40.0 * std::sin(9.0 * lat) * std::cos(8.0 * lon); };
  const auto below =
      raster_of(720, 720, {0.0, 0.0, 8.0, 8.0}, [&](double lat, double lon) { return hills(lat, lon) - 700.0; });
  const auto holes = [](double lat, double lon) {
    return (std::abs(lat - 1.0) < 1.0 / 30 && std::abs(lon - 1.0) < 1.0 / 30) ||
           (std::abs(lat - 5.0) < 1.7 && std::abs(lon - 5.0) < 1.7);
  };
  const auto above = raster_of(720, 720, {0.0, 0.0, 8.0, 8.0},
                               [&](double lat, double lon) { return holes(lat, lon) ? kNan : hills(lat, lon); });
  const HeightSampler s({below, above}, false, nullptr);
  double worst = 0.0, step = 0.0, before = height_deg(s, 0.9, 1.003);
  for (double lat = 0.9; lat < 1.1; lat += 0.0007) {
    const double h = height_deg(s, lat, 1.003);
    worst = std::max(worst, std::abs(h - hills(lat, 1.003)));
    step = std::max(step, std::abs(h - before));
    before = h;
  }
  CHECK(worst < 35.0);  // 5 % of the 700 m that it would be off
  CHECK(step < 10.0);
  CHECK(height_deg(s, 5.0, 5.0) < hills(5.0, 5.0) - 600.0);
  CHECK(height_deg(s, 5.0, 3.4) > hills(5.0, 3.4) - 200.0);
}

TEST_CASE("the default data are bent to a finer raster's edge around it, less and less over one and a half pixels") {
  // Default: hills, one pixel a degree. Above: 700 m higher, and rough.
  const auto world = raster_of(360, 180, {}, [](double, double lon) { return lon < 20.0 ? 400.0 : -60.0; });
  const auto relief = [](double lat, double lon) {
    return 1100.0 + 50.0 * std::sin(20.0 * lat) * std::cos(15.0 * lon);
  };
  const auto dem = raster_of(320, 320, {10.0, 10.0, 14.0, 14.0}, relief);
  const HeightSampler s({world, dem}, true, nullptr), plain({world}, true, nullptr);
  // Across the western, southern and northern edges and a corner: no step, and far from it nothing.
  double step = 0.0, before = height_deg(s, 12.0, 8.0);
  CHECK(before == 400.0);
  for (double t = 0.0; t < 3.0; t += 0.002) {
    const double h = height_deg(s, 12.0, 8.0 + t);
    step = std::max(step, std::abs(h - before));
    before = h;
  }
  CHECK(step < 4.0);  // 700 m over a degree and a half, and the relief's 50 m x 15 / degree
  for (const auto& [lat, lon] :
       {std::pair{9.999, 12.3}, {14.001, 11.1}, {14.001, 14.001}, {9.999, 9.999}, {11.0, 14.001}})
    CHECK(height_deg(s, lat, lon) ==
          doctest::Approx(height_deg(s, std::clamp(lat, 10.01, 13.99), std::clamp(lon, 10.01, 13.99))).epsilon(0.02));
  for (const auto& [lat, lon] : {std::pair{8.45, 12.0}, {15.55, 12.0}, {12.0, 15.6}, {15.2, 15.2}, {-12.0, 12.0}})
    CHECK(height_deg(s, lat, lon) == height_deg(plain, lat, lon));
  // Slopes follow: up towards the raster.
  const double lats[] = {12.0}, lons[] = {9.25, 7.5};
  Slope slopes[2];
  s.slopes(lats, lons, 0.01, slopes);
  CHECK(slopes[0].east > 0.5f * 700.0f / (1.5f * 111195.0f));
  CHECK(slopes[1].east == 0.0f);
  // The sea beside a raster stays sea.
  const HeightSampler shore({world, raster_of(320, 320, {16.0, 10.0, 20.0, 14.0}, relief)}, true, nullptr);
  CHECK(height_deg(shore, 12.0, 20.6) == 0.0);
}

TEST_CASE("the sea that a raster leaves out stays sea") {
  const auto world = raster_of(360, 180, {}, [](double, double lon) { return lon < 8.0 ? -60.0 : 20.0; });
  const auto shore =
      raster_of(160, 160, {0.0, 0.0, 16.0, 16.0}, [](double, double lon) { return lon < 8.0 ? kNan : 5.0; });
  const HeightSampler s({world, shore}, true, nullptr);
  CHECK(height_deg(s, 8.0, 4.0) == 0.0);
  CHECK(height_deg(s, 8.0, 7.0) == 0.0);
  CHECK(height_deg(s, 8.0, 9.0) == doctest::Approx(5.0));
}

TEST_CASE("sea is where the default data and the raster above it are both at or below 0") {
  const auto constant = [](double v) { return [v](double, double) { return v; }; };
  const LonLatBounds box{0.0, 0.0, 16.0, 16.0};
  const auto height = [&](double low, double high, bool has_default) {
    return height_deg(HeightSampler({raster_of(360, 180, {}, constant(low)), raster_of(16, 16, box, constant(high))},
                                    has_default, nullptr),
                      8.0, 8.0);
  };
  CHECK(height(-4000.0, -5.0, true) == 0.0);  // sea bed
  CHECK(height(-4000.0, 7.0, true) == 7.0);   // an island that the default data lacks
  CHECK(height(12.0, -5.0, true) == -5.0);    // a polder
  CHECK(height(12.0, -5.0, false) == 0.0);    // no default data: the stack decides
  CHECK(height(12.0, 5.0, false) == 5.0);
}

TEST_CASE("the geoid is added to heights above mean sea level, not to ellipsoidal ones") {
  const auto geoid = std::make_shared<Geoid>(Geoid::find_egm96());
  if (!geoid->available()) return;
  const auto value = [](double, double) { return 250.0; };
  const double n = geoid->undulation_m(rad_from_deg(5.0), rad_from_deg(80.0));
  CHECK(n < -90.0);  // the deepest dent of the geoid, south of India
  CHECK(height_deg(HeightSampler({raster_of(360, 180, {}, value)}, true, geoid), 5.0, 80.0) == 250.0 + n);
  CHECK(height_deg(HeightSampler({raster_of(360, 180, {}, value, VerticalDatum::ellipsoid)}, false, geoid), 5.0,
                   80.0) == doctest::Approx(250.0).epsilon(1e-13));
  const auto sea = [](double, double) { return -250.0; };
  CHECK(height_deg(HeightSampler({raster_of(360, 180, {}, sea)}, true, geoid), 5.0, 80.0) == n);
}

TEST_CASE("antimeridian and poles are one place each") {
  // 271 columns: not divisible by any reduction.
  const HeightSampler s({rough_world(542)}, false, nullptr);
  for (const uint32_t level : {0u, 3u, 9u}) {
    CHECK(height_deg(s, 33.0, 180.0, level) == height_deg(s, 33.0, -180.0, level));
    const double lats[] = {90.0, 45.0, -90.0}, lons[] = {-180.0, -77.0, 0.0, 180.0};
    double h[12];
    s.heights_m(lats, lons, level, h);
    for (int i = 1; i < 4; ++i) {
      CHECK(h[i] == h[0]);
      CHECK(h[8 + i] == h[8]);
    }
    CHECK(h[0] == height_deg(s, 90.0, 10.0, 17));
  }
  // Continuous across the seam: 1e-7 degrees apart, slopes are below 1e5 m per degree.
  CHECK(height_deg(s, 33.0, 180.0 - 1e-7) == doctest::Approx(height_deg(s, 33.0, -180.0 + 1e-7)).epsilon(1e-4));
}

TEST_CASE("a place has the same bits whichever grid asks") {
  const HeightSampler s(
      {rough_world(), raster_of(300, 300, {0.0, 0.0, 3.0, 3.0},
                                [](double lat, double lon) {
                                  return lat > 1.0 && lat < 1.1 ? kNan : 1000.0 + 500.0 * std::sin(40.0 * lon);
                                })},
      true, nullptr);
  std::vector<double> lats, lons;
  for (int i = 0; i <= 64; ++i) {
    lats.push_back(3.2 - i * 0.05);
    lons.push_back(-0.1 + i * 0.05);
  }
  for (const uint32_t level : {4u, 8u, 12u}) {
    std::vector<double> grid(lats.size() * lons.size());
    s.heights_m(lats, lons, level, grid.data());
    for (size_t j = 0; j < lats.size(); j += 3)
      for (size_t i = 0; i < lons.size(); i += 3) {
        double h = 0.0;
        s.heights_m(std::span(&lats[j], 1), std::span(&lons[i], 1), level, &h);
        REQUIRE(h == grid[j * lons.size() + i]);
      }
  }
}

TEST_CASE("slopes of a plane are its gradient in m per m") {
  const HeightSampler s(
      {raster_of(400, 400, {10.0, 40.0, 14.0, 44.0},
                 [](double lat, double lon) { return 5000.0 + 2000.0 * (lat - 42.0) + 3000.0 * (lon - 12.0); })},
      false, nullptr);
  const double lat[] = {42.0}, lon[] = {12.0};
  Slope slope;
  s.slopes(lat, lon, 0.004, &slope);
  const double m_per_deg = 6371008.8 * std::numbers::pi / 180.0;
  CHECK(static_cast<double>(slope.north) == doctest::Approx(2000.0 / m_per_deg).epsilon(1e-4));
  CHECK(static_cast<double>(slope.east) ==
        doctest::Approx(3000.0 / (m_per_deg * std::cos(rad_from_deg(42.0)))).epsilon(1e-4));
}

TEST_CASE("land near the coast takes its colour from land, not from the sea in the picture") {
  // Land north of the equator; the picture is white on land and black at sea, 1 degree a texel, but its coast lies one
  // degree too far north.
  const auto land = raster_of(3600, 1800, {}, [](double lat, double) { return lat > 0.0 ? 50.0 : -50.0; });
  RasterInfo info;
  info.path = "picture";
  info.width = 360;
  info.height = 180;
  info.bands = 4;
  info.wraps = true;
  std::vector<float> values;
  for (int y = 0; y < 180; ++y)
    for (int x = 0; x < 360; ++x)
      for (int b = 0; b < 4; ++b) values.push_back(b == 3 ? 255.0f : y < 90 ? 200.0f : 10.0f);
  const HeightSampler ground({land}, true, nullptr);
  const ImagerySampler imagery({std::make_shared<ArrayRaster>(info, values)}, ground);
  const double lat[] = {0.01}, lon[] = {7.3};
  float rgbx[4];
  imagery.colours(lat, lon, 0.01, rgbx);
  CHECK(rgbx[0] == doctest::Approx(200.0f));
}

TEST_CASE("imagery without data shows what lies below, and grey of albedo 0.2 below all") {
  RasterInfo info;
  info.path = "patch";
  info.width = info.height = 8;
  info.bands = 4;
  info.bounds = {0.0, 0.0, 8.0, 8.0};
  std::vector<float> values(8 * 8 * 4, 77.0f);
  for (size_t i = 3; i < values.size(); i += 4) values[i] = 255.0f;
  const HeightSampler ground({}, false, nullptr);
  const ImagerySampler imagery({std::make_shared<ArrayRaster>(info, values)}, ground);
  const double lat[] = {4.0, 20.0}, lon[] = {4.0};
  float rgbx[8];
  imagery.colours(lat, lon, 0.01, rgbx);
  CHECK(rgbx[1] == 77.0f);
  CHECK(rgbx[4] == doctest::Approx(255.0 * (1.055 * std::pow(0.2, 1.0 / 2.4) - 0.055)));  // sRGB of albedo 0.2
}

namespace {
/// A raster with another opacity than its own.
class Faded final : public Raster {
 public:
  Faded(std::shared_ptr<Raster> raster, double opacity) : raster_(std::move(raster)), info_(raster_->info()) {
    info_.opacity = opacity;
  }
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return raster_->reductions(); }
  Result<RasterBlock> read_block(uint32_t k, uint32_t bx, uint32_t by) const override {
    return raster_->read_block(k, bx, by);
  }

 private:
  std::shared_ptr<Raster> raster_;
  RasterInfo info_;
};

/// A picture of one colour and alpha, on the square 0..16 degrees.
std::shared_ptr<Raster> picture(std::vector<float> rgba) {
  RasterInfo info;
  info.path = "test";
  info.width = info.height = 16;
  info.bands = 4;
  info.bounds = {0.0, 0.0, 16.0, 16.0};
  std::vector<float> values;
  for (int i = 0; i < 256; ++i) values.insert(values.end(), rgba.begin(), rgba.end());
  return std::make_shared<ArrayRaster>(info, std::move(values));
}
}  // namespace

TEST_CASE("an elevation raster counts by its opacity, the rest is what lies below") {
  const auto below = raster_of(360, 180, {}, [](double, double) { return 100.0; });
  const auto above = raster_of(16, 16, {0.0, 0.0, 16.0, 16.0}, [](double, double) { return 300.0; });
  for (const double opacity : {0.0, 0.25, 1.0}) {
    const HeightSampler s({below, std::make_shared<Faded>(above, opacity)}, false, nullptr);
    CHECK(height_deg(s, 4.5, 4.5) == doctest::Approx(100.0 + opacity * 200.0));
    CHECK(height_deg(s, 4.5, 20.5) == 100.0);
    CHECK(height_deg(s, 4.5, 16.0) == doctest::Approx(100.0 + 0.5 * opacity * 200.0));  // the seam
  }
}

TEST_CASE("a picture counts by its alpha") {
  const HeightSampler ground({}, false, nullptr);
  const ImagerySampler sampler({picture({200, 100, 0, 255}), picture({0, 0, 100, 51})}, ground, 0.2);
  const double lat[] = {8.0}, lon[] = {8.0, 40.0};
  std::vector<float> rgbx(8);
  sampler.colours(lat, lon, 0.1, rgbx.data());
  CHECK(rgbx[0] == doctest::Approx(160.0));  // 0.8 of the lower, 0.2 of the upper one
  CHECK(rgbx[1] == doctest::Approx(80.0));
  CHECK(rgbx[2] == doctest::Approx(20.0));
  CHECK(rgbx[4] == rgbx[5]);  // bare ground
}
