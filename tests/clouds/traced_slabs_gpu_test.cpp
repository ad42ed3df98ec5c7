#include "clouds/traced_slabs.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "clouds/cloud_test_tools.h"
#include "clouds/droplet_phase.h"
#include "common/random.h"
#include "common/sampling.h"
#include "gpu/gpu_fixture.h"
#include "oracles/oracle_path.h"

namespace nepho {
namespace {

struct OracleRow {
  Slab slab;
  SlabLight light;
};

std::vector<OracleRow> oracle_rows() {
  std::ifstream file(test::oracle_path("slab_dev.csv"));
  REQUIRE(file);
  std::string line, cell;
  std::getline(file, line);
  std::vector<OracleRow> rows;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> v;
    while (std::getline(cells, cell, ',')) v.push_back(std::stod(cell));
    REQUIRE(v.size() == 7 + kSlabDirections);
    OracleRow row{.slab = {.tau = v[0], .single_scattering_albedo = v[1], .g = v[2], .mu0 = v[3]}, .light = {}};
    row.light.reflectance = v[4];
    row.light.transmittance_direct = v[5];
    row.light.transmittance_diffuse = v[6];
    for (size_t i = 0; i < kSlabDirections; ++i) row.light.radiance[i] = v[7 + i];
    rows.push_back(row);
  }
  return rows;
}

/// `share` of the oracle or so many standard errors, its own among them.
void check_near(double value, double error, double oracle, double oracle_error, double share, double errors) {
  CAPTURE(value);
  CAPTURE(error);
  CAPTURE(oracle);
  CHECK(std::abs(value - oracle) <= std::max(share * oracle, errors * std::hypot(error, oracle_error)));
}

void check_row(const TracedSlab& traced, const OracleRow& row) {
  const Slab& s = row.slab;
  INFO("tau ", s.tau, " omega0 ", s.single_scattering_albedo, " g ", s.g, " mu0 ", s.mu0);
  // The oracle's README: fluxes to 0.1 % of what comes in, radiances to 1 to 3 %.
  check_near(traced.light.reflectance, traced.error.reflectance, row.light.reflectance, 0.001, 0.01, 3.0);
  check_near(traced.light.transmittance_direct, traced.error.transmittance_direct, row.light.transmittance_direct,
             0.001, 0.01, 3.0);
  check_near(traced.light.transmittance_diffuse, traced.error.transmittance_diffuse, row.light.transmittance_diffuse,
             0.001, 0.01, 3.0);
  for (size_t i = 0; i < kSlabDirections; ++i) {
    CAPTURE(slab_directions()[i].name());
    check_near(traced.light.radiance[i], traced.error.radiance[i], row.light.radiance[i], 0.03 * row.light.radiance[i],
               0.05, 4.0);
  }
}

size_t direction_index(const SlabDirection& direction) {
  for (size_t i = 0; i < kSlabDirections; ++i)
    if (slab_directions()[i] == direction) return i;
  FAIL("no such direction");
  return 0;
}

TEST_CASE("gpu: traced slabs send what the oracle's do") {
  GpuFixture f;
  TracedSlabs tracer(f.device, test::full_size() ? 0.0 : 0.04);
  size_t checked = 0;
  for (const OracleRow& row : oracle_rows()) {
    const Slab& s = row.slab;
    const bool one_of_three = (s == Slab{.tau = 1.0, .g = 0.85, .mu0 = s.mu0} && s.mu0 == 0.7) ||
                              (s == Slab{.tau = 8.0, .g = 0.0, .mu0 = 1.0}) ||
                              (s == Slab{.tau = 4.0, .single_scattering_albedo = 0.99, .g = 0.5, .mu0 = 1.0});
    if (!test::full_size() && !one_of_three) continue;
    check_row(tracer.trace(s), row);
    ++checked;
  }
  CHECK(checked == (test::full_size() ? 128 : 3));
}

TEST_CASE("gpu: light goes through a traced slab the other way as well: R(mu, mu0) = R(mu0, mu)") {
  GpuFixture f;
  TracedSlabs tracer(f.device, 0.04);
  const Slab slab{.tau = 2.0, .g = 0.5, .mu0 = 0.7};
  Slab turned = slab;
  turned.mu0 = 0.5;
  const size_t a = direction_index({.up = true, .mu = 0.5, .phi_deg = 90.0}),
               b = direction_index({.up = true, .mu = 0.7, .phi_deg = 90.0});
  const TracedSlab one = tracer.trace(slab), other = tracer.trace(turned);
  const double error = std::hypot(one.error.radiance[a] / 0.7, other.error.radiance[b] / 0.5);
  CHECK(one.light.radiance[a] / 0.7 > 12.0 * error);
  CHECK(std::abs(one.light.radiance[a] / 0.7 - other.light.radiance[b] / 0.5) < 4.0 * error);
}

TEST_CASE("gpu: a traced slab without absorption loses nothing; one that only absorbs sends nothing") {
  GpuFixture f;
  TracedSlabs tracer(f.device, 0.04);
  const TracedSlab bright = tracer.trace({.tau = 1.0, .g = 0.0, .mu0 = 1.0});
  const SlabLight& l = bright.light;
  CHECK(std::abs(l.reflectance + l.transmittance_direct + l.transmittance_diffuse - 1.0) <
        4.0 * std::hypot(bright.error.reflectance, bright.error.transmittance_diffuse));
  CHECK(std::abs(l.reflectance - 0.341) < 0.0005 + 4.0 * bright.error.reflectance);  // van de Hulst 1980
  const TracedSlab black = tracer.trace({.tau = 1.0, .single_scattering_albedo = 0.0, .g = 0.5, .mu0 = 0.5});
  CHECK(black.light.reflectance == 0.0);
  for (const double radiance : black.light.radiance) CHECK(radiance == 0.0);
  CHECK(std::abs(black.light.transmittance_direct - std::exp(-2.0)) < 4.0 * black.error.transmittance_direct);
  CHECK(black.light.transmittance_diffuse < 4.0 * black.error.transmittance_diffuse);
}

/// Reflectance of a slab under photons, one after the other, whose cosines are drawn as tests/common shows to be right.
double photon_reflectance(const Slab& slab, int photons) {
  const shared::PhaseLobes phase = mie_fit(slab.droplet_diameter_um).constants();
  shared::Random random = shared::random_stream(3u, 1u, 4u);
  const auto unit = [&random] { return static_cast<double>(shared::random_unit(random)); };
  int out = 0;
  for (int i = 0; i < photons; ++i) {
    double depth = 0.0, mu = slab.mu0;  // downwards
    while (true) {
      depth -= std::log(1.0 - unit()) * mu;
      if (depth < 0.0 || depth > slab.tau) break;
      const double c = static_cast<double>(shared::sample_lobes_cosine(phase, static_cast<float>(unit())));
      mu = mu * c + std::sqrt((1.0 - mu * mu) * (1.0 - c * c)) * std::cos(2.0 * std::numbers::pi * unit());
      mu = std::clamp(mu, -1.0, 1.0);
    }
    out += depth < 0.0 ? 1 : 0;
  }
  return static_cast<double>(out) / photons;
}

TEST_CASE("gpu: droplets with Mie's fit: the path tracer reflects what photons do, cells within 10 %") {
  GpuFixture f;
  const Slab slab{.tau = 4.0, .mu0 = 0.7, .droplet_diameter_um = 20.0};
  constexpr int kPhotons = 400000;
  const double photons = photon_reflectance(slab, kPhotons);
  const TracedSlab traced = TracedSlabs(f.device, 0.04).trace(slab);
  CAPTURE(photons);
  CHECK(std::abs(traced.light.reflectance - photons) <
        4.0 * std::hypot(traced.error.reflectance, std::sqrt(0.2 / kPhotons)));
  CHECK(traced.error.reflectance < 0.02 * photons);
  const SlabLight cells = MarchedSlabs(f.device, "cells", 8).solve({&slab, 1}).front();
  MESSAGE("reflectance: photons ", photons, ", traced ", traced.light.reflectance, " +- ", traced.error.reflectance,
          ", cells ", cells.reflectance);
  CHECK(std::abs(cells.reflectance / photons - 1.0) < 0.1);
  CHECK(cells.transmittance_direct == doctest::Approx(std::exp(-4.0 / 0.7)).epsilon(0.02));
}

}  // namespace
}  // namespace nepho
