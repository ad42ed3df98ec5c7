#pragma once
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "clouds/cloud_probe.h"
#include "clouds/statistics.h"
#include "geo/frames.h"
#include "gpu/gpu_fixture.h"

namespace nepho::test {

/// NEPHO_TEST_FULL=1 asks for the figures of the issue at their full sizes, which take minutes.
inline bool full_size() {
  const char* full = std::getenv("NEPHO_TEST_FULL");
  return full && std::string(full) == "1";
}

/// A genus preset above the ellipsoid, so that it needs no rasters.
inline CloudLayer genus_layer(const std::string& name) {
  CloudLayer layer = cloud_genus(name).value();
  layer.base_reference = "ellipsoid";
  return layer;
}

/// One genus under the same weather everywhere.
inline CloudParams genus_sky(const std::string& name, double coverage) {
  CloudParams params;
  params.coverage = coverage;
  params.layers = {genus_layer(name)};
  return params;
}

/// A place on the ellipsoid, and what lies metres east and north of it: tangential, then down to the height.
class Patch {
 public:
  Patch(double lat_deg, double lon_deg)
      : ecef_from_enu_(make_ecef_from_enu(Geodetic::from_degrees(lat_deg, lon_deg))) {}
  Geodetic at(double east_m, double north_m, double height_m = 0.0) const {
    Geodetic g = geodetic_from_ecef(dvec3(ecef_from_enu_ * glm::dvec4(east_m, north_m, 0.0, 1.0)));
    g.height_m = height_m;
    return g;
  }

 private:
  dmat4 ecef_from_enu_;
};

struct Place {
  double lat_deg, lon_deg;
};

/// The middle of a window of patterns (clouds/cloud_anchor.h), some day: all tests without a time of their own are
/// there.
constexpr double kQuietTime_s = 20.5 * kWindow_s;

/// `side` x `side` columns over a square, at the centres of its pixels; row 0 is the south.
inline std::vector<CloudProbe::Case> square_cases(const Place& place, double side_m, size_t side, double footprint_m,
                                                  double time_s = kQuietTime_s) {
  const Patch patch(place.lat_deg, place.lon_deg);
  std::vector<CloudProbe::Case> cases;
  cases.reserve(side * side);
  const double pixel_m = side_m / static_cast<double>(side);
  for (size_t y = 0; y < side; ++y)
    for (size_t x = 0; x < side; ++x)
      cases.push_back({.point = patch.at((static_cast<double>(x) + 0.5) * pixel_m - 0.5 * side_m,
                                         (static_cast<double>(y) + 0.5) * pixel_m - 0.5 * side_m),
                       .camera = {},
                       .time_s = time_s,
                       .footprint_m = footprint_m});
  return cases;
}

inline double total_depth(const CloudProbe::Column& c) {
  return static_cast<double>(c.optical_depth.x) + static_cast<double>(c.optical_depth.y) +
         static_cast<double>(c.optical_depth.z) + static_cast<double>(c.optical_depth.w);
}

inline Grid depth_grid(CloudProbe& probe, const Place& place, double side_m, size_t side, double footprint_m,
                       double time_s = kQuietTime_s) {
  Grid grid(side, side);
  const auto columns = probe.column(square_cases(place, side_m, side, footprint_m, time_s));
  for (size_t i = 0; i < columns.size(); ++i) grid.values[i] = total_depth(columns[i]);
  return grid;
}

}  // namespace nepho::test
