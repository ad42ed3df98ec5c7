// `nepho probe` of the clouds, table in, table out, where closed forms or definitions say what must come out.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "base/error.h"
#include "nepho/probe_results.h"
#include "weather/weather_map.h"

using namespace nepho;

namespace {

ProbeOptions sky(const CloudParams& clouds) {
  ProbeOptions options;
  options.scene.clouds = clouds;
  return options;
}

/// An even slab from 1000 to 3000 m above the ellipsoid, of extinction 0.5 * (0.03 + 0.01) / m.
CloudParams slab() {
  CloudParams clouds;
  clouds.coverage = 1.0;
  clouds.uniform_density = 0.5;
  clouds.scattering_per_m = 0.03;
  clouds.absorption_per_m = 0.01;
  clouds.layers = {CloudLayer{.base_m = 1000.0, .thickness_m = 2000.0}};
  return clouds;
}

using Results = test::ProbeResults;

constexpr const char* kPlaces = "lat_deg,lon_deg\n0,0\n35.3,138.7\n-90,10\n60,-180\n89.99,359\n";

}  // namespace

TEST_CASE("a clear sky has no density, no optical depth, and blank bases and tops") {
  const ProbeOptions clear = sky(cloud_sky("clear").value());
  const Results columns("column", kPlaces, clear);
  REQUIRE(columns.size() == 5);
  for (size_t row = 0; row < columns.size(); ++row) {
    for (const char* name :
         {"optical_depth_r", "optical_depth_g", "optical_depth_b", "optical_depth_a", "optical_depth"})
      CHECK(columns.number(row, name) == 0.0);
    CHECK(columns.text(row, "base_m").empty());
    CHECK(columns.text(row, "top_m").empty());
  }
  const Results points("density", "lat_deg,lon_deg,height_m\n10,20,1800\n10,20,9000\n", clear);
  for (size_t row = 0; row < points.size(); ++row) CHECK(points.number(row, "extinction_per_m") == 0.0);
}

TEST_CASE("an even slab has its extinction inside, none outside, and the optical depth extinction times thickness") {
  const Results columns("column", kPlaces, sky(slab()));
  REQUIRE(columns.size() == 5);
  for (size_t row = 0; row < columns.size(); ++row) {
    CHECK(columns.number(row, "optical_depth") == doctest::Approx(40.0).epsilon(1e-3));  // single precision, 40 samples
    CHECK(columns.number(row, "optical_depth_r") == columns.number(row, "optical_depth"));
    CHECK(columns.number(row, "base_m") == doctest::Approx(1000.0).epsilon(1e-3));
    CHECK(columns.number(row, "top_m") == doctest::Approx(3000.0).epsilon(1e-3));
  }
  const Results points("density", "lat_deg,lon_deg,height_m\n10,20,900\n10,20,1100\n10,20,2900\n10,20,3100\n",
                       sky(slab()));
  CHECK(points.number(0, "extinction_per_m") == 0.0);
  CHECK(points.number(1, "extinction_per_m") == doctest::Approx(0.02).epsilon(1e-5));
  CHECK(points.number(2, "extinction_per_m") == doctest::Approx(0.02).epsilon(1e-5));
  CHECK(points.number(2, "density_r") == doctest::Approx(0.5).epsilon(1e-5));
  CHECK(points.number(2, "density_g") == 0.0);
  CHECK(points.number(3, "extinction_per_m") == 0.0);
}

TEST_CASE("uniform weather is its coverage in every channel where it is 0 or 1") {
  for (const double coverage : {0.0, 1.0}) {
    CloudParams clouds = cloud_sky("cumulus").value();
    clouds.coverage = coverage;
    const Results weather("weather", kPlaces, sky(clouds));
    REQUIRE(weather.size() == 5);
    for (size_t row = 0; row < weather.size(); ++row)
      CHECK(weather.number(row, "coverage_r") == doctest::Approx(coverage).epsilon(1e-3));
  }
}

TEST_CASE("without a time it is the scene's, without a footprint of columns it is 10 m; blank cells are the same") {
  CloudParams clouds = cloud_sky("cumulus").value();
  clouds.layers[0].wind_east_mps = 20.0;
  clouds.layers[0].base_reference = "ellipsoid";
  ProbeOptions options = sky(clouds);
  options.scene.time = "2026-06-20T06:00:00Z";
  std::string plain = "lat_deg,lon_deg\n", said = "lat_deg,lon_deg,time,footprint_m\n",
              blank = "lat_deg,lon_deg,time,footprint_m\n", later = "lat_deg,lon_deg,time\n";
  for (int i = 0; i < 40; ++i) {
    const std::string place_i = fmt::format("{},{}", 12.5 + 0.05 * i, 45.25);
    plain += place_i + "\n";
    said += place_i + ",2026-06-20T08:00+02:00,10\n";
    blank += place_i + ",,\n";
    later += place_i + ",2026-06-20T07:00:00Z\n";
  }
  const Results a("column", plain, options), b("column", said, options), c("column", blank, options),
      d("column", later, options);
  int covered = 0, moved = 0;
  for (size_t row = 0; row < a.size(); ++row) {
    const std::string& depth = a.text(row, "optical_depth");
    CHECK(b.text(row, "optical_depth") == depth);
    CHECK(c.text(row, "optical_depth") == depth);
    covered += std::stod(depth) > 1.0 ? 1 : 0;
    moved += d.text(row, "optical_depth") != depth ? 1 : 0;
  }
  CHECK(covered > 4);  // of 40 columns 5.5 km apart at coverage 0.4; chance of fewer below 1e-4
  CHECK(moved > 4);
}
