#include "clouds/slab_probe.h"

#include <doctest/doctest.h>

#include <fstream>
#include <sstream>

#include "oracles/oracle_path.h"

using namespace nepho;

TEST_CASE("slab directions have the names of the oracle's columns, in their order") {
  std::ifstream file(test::oracle_path("slab_dev.csv"));
  REQUIRE(file);
  std::string line, cell;
  std::getline(file, line);
  std::istringstream header(line);
  std::vector<std::string> names;
  while (std::getline(header, cell, ',')) names.push_back(cell);
  REQUIRE(names.size() == 7 + kSlabDirections);
  for (size_t i = 0; i < kSlabDirections; ++i) CHECK(slab_directions()[i].name() == names[7 + i]);
}

TEST_CASE("the layer of a slab has its optical thickness, albedo and one lobe, and no light but the sun's") {
  const CloudParams clouds = slab_clouds({.tau = 8.0, .single_scattering_albedo = 0.75, .g = 0.5, .mu0 = 0.2});
  const double extinction_per_m = clouds.scattering_per_m + clouds.absorption_per_m;
  CHECK(extinction_per_m * clouds.layers.at(0).thickness_m * clouds.uniform_density == doctest::Approx(8.0));
  CHECK(clouds.scattering_per_m / extinction_per_m == doctest::Approx(0.75));
  CHECK(clouds.phase_g_forward == 0.5);
  CHECK(clouds.phase_backward_weight == 0.0);
  CHECK(clouds.sky_light_scale == 0.0);
  CHECK(clouds.ground_bounce_scale == 0.0);
}
