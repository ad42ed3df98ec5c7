// The atmosphere's tables and lookups on the device against the oracles. Columns are explained in the README of the
// shared oracles; `_exact` and Monte Carlo are the truth, L_direct takes its orders 2 to 4 from the common model's
// coarse tables and is about 1 % low. 'Day' is mu_s > 0.05. The tolerances are about 1.5 to 2 times what is measured
// (test_atmosphere_gpu -s shows it), and nowhere wider than what was asked for.
#include <doctest/doctest.h>

#include <glm/vector_relational.hpp>
#include <map>

#include "atmosphere/atmosphere_fixture.h"
#include "atmosphere/oracle_table.h"

using namespace nepho;

namespace {

const Ellipsoid kDemoPlanet = Ellipsoid::sphere(6360000.0);

shared::AtmosphereCase angle_case(const OracleTable& table, size_t row) {
  shared::AtmosphereCase c{};
  c.h = static_cast<float>(table.number(row, "r_m") - kDemoPlanet.a_m);
  return c;
}

std::vector<shared::AtmosphereCase> view_cases(const OracleTable& table) {
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < table.size(); ++i)
    cases.push_back(view_case(table.xyz(i, "cam", "_m"), table.xyz(i, "view"), table.xyz(i, "sun"),
                              table.number(i, "hits_ground") > 0.5, kDemoPlanet));
  return cases;
}

bool by_day(const OracleTable& table, size_t row) { return table.number(row, "mu_s") > 0.05; }

/// Errors by class of camera and ray.
class ClassErrors {
 public:
  void add(const std::string& name, const glm::vec3& found, const glm::dvec3& truth, double floor) {
    by_name_.try_emplace(name, name).first->second.add_relative(found, truth, floor);
  }
  void check(size_t count, double median, double p95, double worst = 1e300) const {
    REQUIRE(by_name_.size() == count);
    for (const auto& [name, error] : by_name_) error.check(median, p95, worst);
  }

 private:
  std::map<std::string, ErrorStatistics> by_name_;
};

/// Where a camera is.
std::string camera_class(const OracleTable& table, size_t row) {
  const double height = table.number(row, "r_m") - kDemoPlanet.a_m;
  return height < 100.0 ? "camera under 100 m" : height < 12e3 ? "to 12 km" : height < 60e3 ? "to 60 km" : "space";
}

}  // namespace

TEST_CASE("transmittance to the top agrees with the exact integral to 5e-4") {
  AtmosphereFixture gpu;
  const OracleTable table("transmittance.csv");
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < table.size(); ++i) {
    cases.push_back(angle_case(table, i));
    cases.back().mu = static_cast<float>(table.number(i, "mu"));
  }
  const auto answers = gpu.ask(bruneton_demo(4), shared::kProbeTransmittance, cases);
  ErrorStatistics error("transmittance, absolute");
  for (size_t i = 0; i < table.size(); ++i) error.add_absolute(answers[i].a, table.rgb(i, "T_exact"));
  error.check(4e-5, 3e-4, 5e-4);
}

TEST_CASE("single scattering by day agrees with the exact integral to 0.1 % (95 %)") {
  AtmosphereFixture gpu;
  const OracleTable table("single_scattering.csv");
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < table.size(); ++i) {
    shared::AtmosphereCase c = angle_case(table, i);
    c.mu = static_cast<float>(table.number(i, "mu"));
    c.mu_s = static_cast<float>(table.number(i, "mu_s"));
    c.nu = static_cast<float>(table.number(i, "nu"));
    c.hits_ground = table.number(i, "hits_ground") > 0.5 ? 1u : 0u;
    cases.push_back(c);
  }
  const auto answers = gpu.ask(bruneton_demo(4), shared::kProbeSingleScattering, cases);
  ErrorStatistics gas_sky("gas, to space"), aerosol_sky("aerosol, to space");
  ErrorStatistics gas_ground("gas, to the ground"), aerosol_ground("aerosol, to the ground");
  for (size_t i = 0; i < table.size(); ++i) {
    if (!by_day(table, i)) continue;
    const bool ground = cases[i].hits_ground != 0;
    (ground ? gas_ground : gas_sky).add_relative(answers[i].a, table.rgb(i, "ray_exact"), 1e-4);
    (ground ? aerosol_ground : aerosol_sky).add_relative(answers[i].b, table.rgb(i, "mie_exact"), 1e-4);
  }
  gas_sky.check(2e-4, 1.2e-3, 3e-3);
  aerosol_sky.check(2e-4, 1.6e-3, 2.5e-2);
  gas_ground.check(1.2e-4, 6e-4, 2e-3);
  aerosol_ground.check(2.5e-4, 1.6e-3, 4e-3);
}

TEST_CASE("sky radiance of order 1 agrees with the exact integral: day 0.03 % (median), 0.3 % (95 %)") {
  AtmosphereFixture gpu;
  const OracleTable table("sky_radiance.csv");
  const auto cases = view_cases(table);
  const auto answers = gpu.ask(bruneton_demo(1), shared::kProbeSkyRadiance, cases);
  ClassErrors day, low;
  ErrorStatistics transmittance("transmittance, absolute"), all_day("all by day");
  for (size_t i = 0; i < table.size(); ++i) {
    if (!cases[i].hits_ground) transmittance.add_absolute(answers[i].b, table.rgb(i, "T_exact"));
    const bool is_day = by_day(table, i);
    ClassErrors& errors = is_day ? day : low;
    const double floor = is_day ? 1e-3 : 1e-4;
    const glm::dvec3 truth = table.rgb(i, "L_single_exact");
    if (is_day) all_day.add_relative(answers[i].a, truth, floor);
    errors.add(camera_class(table, i), answers[i].a, truth, floor);
    errors.add(cases[i].hits_ground ? "ground" : "sky", answers[i].a, truth, floor);
  }
  transmittance.check(6e-5, 4e-4, 1e-3);
  all_day.check(3e-4, 3e-3, 6e-3);
  day.check(6, 6e-4, 3.5e-3, 6e-3);
  low.check(6, 6e-4, 8e-3, 2e-2);
}

TEST_CASE("sky radiance of orders 1 to 4 agrees with Monte Carlo: sun up 0.2 % (median), 0.6 % (95 %), twilight 8 %") {
  AtmosphereFixture gpu;
  const OracleTable table("mc_sky_radiance.csv");
  const auto answers = gpu.ask(bruneton_demo(4), shared::kProbeSkyRadiance, view_cases(table));
  ErrorStatistics day("sun above the horizon"), twilight("twilight"), sure("twilight, where Monte Carlo is sure");
  for (size_t i = 0; i < table.size(); ++i) {
    const bool up = table.number(i, "mu_s") > 0.0;
    const glm::dvec3 truth = table.rgb(i, "L_mc"), se = table.rgb(i, "se");
    (up ? day : twilight).add_relative(answers[i].a, truth, up ? 1e-3 : 1e-4);
    // Its own standard error is up to 30 % there: no verdict on 8 % comes of such rows.
    if (!up && glm::all(glm::lessThan(se, 0.02 * glm::max(truth, glm::dvec3(1e-4)))))
      sure.add_relative(answers[i].a, truth, 1e-4);
  }
  day.check(2e-3, 6e-3, 1e-2);
  twilight.check(4e-3, 8e-2);
  sure.check(2e-3, 8e-3, 6e-2);
}

TEST_CASE("sky radiance of orders 1 to 4 by day agrees with the common model's: 1.2 % (median), 4 % (95 %)") {
  AtmosphereFixture gpu;
  const OracleTable table("sky_radiance.csv");
  const auto cases = view_cases(table);
  const auto answers = gpu.ask(bruneton_demo(4), shared::kProbeSkyRadiance, cases);
  ErrorStatistics day("day"), low("low sun");
  for (size_t i = 0; i < table.size(); ++i) {
    const bool is_day = by_day(table, i);
    (is_day ? day : low).add_relative(answers[i].a, table.rgb(i, "L_direct"), is_day ? 1e-3 : 1e-4);
  }
  day.check(1.2e-2, 4e-2, 0.15);
  low.check(2e-2, 8e-2);
}

TEST_CASE("light up to a point, order 1, agrees with the exact integral to 0.1 % (95 %) at every distance, by day") {
  AtmosphereFixture gpu;
  const OracleTable table("sky_radiance_to_point.csv");
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < table.size(); ++i) {
    const glm::dvec3 camera = table.xyz(i, "cam", "_m"), point = table.xyz(i, "pt", "_m");
    cases.push_back(view_case(camera, point - camera, table.xyz(i, "sun"), true, kDemoPlanet));
    cases.back().distance_m = static_cast<float>(glm::length(point - camera));
  }
  const auto all = gpu.ask(bruneton_demo(4), shared::kProbeRadianceToPoint, cases);
  const auto single = gpu.ask(bruneton_demo(1), shared::kProbeRadianceToPoint, cases);
  ClassErrors first;
  ErrorStatistics day("orders 1 to 4, day, against L_direct"), transmittance("of the segment, absolute");
  for (size_t i = 0; i < table.size(); ++i) {
    transmittance.add_absolute(all[i].b, table.rgb(i, "T_exact"));
    if (!by_day(table, i)) continue;
    day.add_relative(all[i].a, table.rgb(i, "L_direct"), 1e-3);
    const double km = table.number(i, "distance_m") / 1000.0;
    const char* name = km < 1     ? "< 1 km"
                       : km < 10  ? "< 10 km"
                       : km < 100 ? "< 100 km"
                       : km < 350 ? "< 350 km"
                                  : "space";
    first.add(name, single[i].a, table.rgb(i, "L_single_exact"), 1e-3);
    if (table.number(i, "cam_r_m") < kDemoPlanet.a_m + 100.0)
      first.add("camera under 100 m", single[i].a, table.rgb(i, "L_single_exact"), 1e-3);
  }
  transmittance.check(1e-5, 3e-4, 1e-3);
  day.check(1.2e-2, 4e-2, 0.12);
  first.check(6, 2e-4, 1e-3, 4e-3);
}

TEST_CASE("irradiance by day: of the sun within 2e-3 of the exact one, of the sky 0.8 % (median), 4 % (95 %)") {
  AtmosphereFixture gpu;
  const OracleTable table("ground_irradiance.csv");
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < table.size(); ++i) {
    cases.push_back(angle_case(table, i));
    cases.back().mu_s = static_cast<float>(table.number(i, "mu_s"));
  }
  const auto all = gpu.ask(bruneton_demo(3), shared::kProbeIrradiance, cases);  // the oracle sums sky orders 1 to 3
  const auto single = gpu.ask(bruneton_demo(1), shared::kProbeIrradiance, cases);
  ErrorStatistics direct("direct, day"), sky("sky, day"), ground("sky at the ground, day"),
      first("sky of order 1, day"), low("sky, sun low or below");
  for (size_t i = 0; i < table.size(); ++i) {
    const glm::dvec3 truth = table.rgb(i, "indirect_integrated");
    if (!by_day(table, i)) {
      low.add_relative(all[i].b, truth, 1e-3);
      continue;
    }
    direct.add_relative(all[i].a, table.rgb(i, "direct_exact"), 1e-3);
    sky.add_relative(all[i].b, truth, 1e-3);
    if (table.number(i, "r_m") < kDemoPlanet.a_m + 100.0) ground.add_relative(all[i].b, truth, 1e-3);
    first.add_relative(single[i].b, table.rgb(i, "ind_order1"), 1e-3);
  }
  direct.check(4e-5, 5e-4, 2e-3);
  sky.check(8e-3, 4e-2, 7e-2);
  ground.check(6e-3, 2.5e-2, 3.5e-2);
  first.check(2e-2, 4e-2, 4e-2);
  // With a low sun the oracle's own tables are off (atmosphere_hemisphere_test.cpp is the better witness).
  low.check(8e-3, 7e-2, 0.15);
}
