// Precision: a point's density does not depend on the camera through which it is looked at.
#include <algorithm>
#include <cmath>

#include "clouds/cloud_test_tools.h"

namespace nepho::test {
namespace {

TEST_CASE(
    "gpu: density through cameras 1 m and 10 km away differs by less than 1 % of full scale, through one 10,000 km "
    "away "
    "by no more than the field changes over 2 m, for every genus and with winds") {
  GpuFixture gpu;
  constexpr Place kPlaces[] = {{35.5, 138.7}, {-62.0, -100.0}, {0.3, 179.999}};
  for (const std::string& genus : cloud_genus_names()) {
    CAPTURE(genus);
    CloudParams params = genus_sky(genus, 0.6);
    CloudLayer& layer = params.layers[0];
    layer.wind_east_mps = 15.0;
    layer.wind_north_mps = 7.0;
    layer.density_scale = 1.0;  // densities are 0..1
    const Clouds clouds(gpu.device, params);
    CloudProbe probe(gpu.device, clouds);
    std::vector<CloudProbe::Case> near, middle, far, beside;
    for (const Place& place : kPlaces) {
      const Patch patch(place.lat_deg, place.lon_deg);
      for (int i = 0; i < 1500; ++i) {
        const double east = 137.0 * (i % 50), north = 141.0 * (i / 50);
        const double height = layer.base_m + layer.thickness_m * (0.03 + 0.5 * (i % 37) / 37.0);
        const double time = (3 + i % 5) * kWindow_s + 41000.0;  // 5.4 h after the middle
        const Geodetic point = patch.at(east, north, height);
        near.push_back({.point = point, .camera = patch.at(east + 1.0, north, height), .time_s = time});
        middle.push_back({.point = point, .camera = patch.at(east + 6e3, north - 8e3, height), .time_s = time});
        far.push_back({.point = point, .camera = patch.at(east, north, 1e7), .time_s = time});
        // Two metres aslant: fibres of cirrus hardly change eastwards.
        beside.push_back({.point = patch.at(east + 1.2, north + 1.2, height + 1.1),
                          .camera = patch.at(east + 1.0, north, height),
                          .time_s = time});
      }
    }
    const auto a = probe.density(near), b = probe.density(middle), c = probe.density(far), d = probe.density(beside);
    double full = 0.0, most = 0.0, space = 0.0, change = 0.0, space_most = 0.0, change_most = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
      const auto apart = [&](const std::vector<CloudProbe::Density>& other) {
        return std::abs(static_cast<double>(a[i].density.x) - static_cast<double>(other[i].density.x));
      };
      full = std::max(full, static_cast<double>(a[i].density.x));
      most = std::max(most, apart(b));
      space += apart(c) / static_cast<double>(a.size());
      change += apart(d) / static_cast<double>(a.size());
      space_most = std::max(space_most, apart(c));
      change_most = std::max(change_most, apart(d));
    }
    MESSAGE(genus, ": 10 km at most ", most, " of ", full, "; 10,000 km mean ", space, ", most ", space_most,
            "; over 2 m mean ", change, ", most ", change_most);
    CHECK(full > 0.3);  // there is cloud
    CHECK(most < 0.01);
    CHECK(space <= change);
    CHECK(space_most <= change_most);
  }
}

}  // namespace
}  // namespace nepho::test
