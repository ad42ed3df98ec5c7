// `nepho probe` of the air, table in, table out, against the oracles. 'Day' is mu_s > 0.05; the floors of relative
// errors are those of the oracles' README: 1e-3 by day, 1e-4 with a low sun.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <sstream>

#include "atmosphere/oracle_table.h"
#include "base/error.h"
#include "base/files.h"
#include "nepho/probe_results.h"

using namespace nepho;

namespace {

std::string oracle_text(const std::string& name) { return read_text_file(test::oracle_path(name + ".csv")); }

ProbeOptions demo(int orders) {
  ProbeOptions options;
  options.scene.atmosphere = AtmosphereParams::bruneton_demo();
  options.scene.atmosphere.scattering_orders = orders;
  return options;
}

/// With colours.
class Results : public test::ProbeResults {
 public:
  using ProbeResults::ProbeResults;
  glm::vec3 rgb(size_t row, const std::string& name) const {
    return {number(row, name + "_680"), number(row, name + "_550"), number(row, name + "_440")};
  }
};

/// The error of a probe that must fail and must have written nothing. There is no such device: rows are judged first.
Error probe_error(const std::string& kind, const std::string& table) {
  ProbeOptions options = demo(4);
  options.device = "no such device";
  std::istringstream in(table);
  std::ostringstream out;
  try {
    run_probe(kind, in, out, options);
  } catch (const Error& e) {
    CHECK(out.str().empty());
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    return e;
  }
  FAIL("no error from: " << table);
  return Error(ErrorKind::failure, "");
}

std::string drop_column(const std::string& table, const std::string& column) {
  std::istringstream in(table);
  std::string out;
  const std::vector<CsvRecord> records = read_csv(in);
  const auto at = std::find(records[0].cells.begin(), records[0].cells.end(), column) - records[0].cells.begin();
  for (CsvRecord record : records) {
    record.cells.erase(record.cells.begin() + at);
    for (const std::string& cell : record.cells) out += cell + ',';
    out.back() = '\n';
  }
  return out;
}

bool by_day(const OracleTable& table, size_t row) { return table.number(row, "mu_s") > 0.05; }

}  // namespace

TEST_CASE("transmittance is within 5e-4 of the exact integral, from the ground to the top") {
  const OracleTable table("transmittance.csv");
  const Results found("transmittance", oracle_text("transmittance"), demo(1));
  CHECK(found.header() == std::vector<std::string>{"id", "r_m", "mu", "T_680", "T_550", "T_440"});
  REQUIRE(found.size() == table.size());
  ErrorStatistics error("transmittance");
  for (size_t i = 0; i < table.size(); ++i) error.add_absolute(found.rgb(i, "T"), table.rgb(i, "T_exact"));
  error.check(1e-4, 3e-4, 5e-4);
}

TEST_CASE("single scattering by gas and aerosol by day: median 0.2 %, 95 % of rows 1 %") {
  const OracleTable table("single_scattering.csv");
  const Results found("single_scattering", oracle_text("single_scattering"), demo(1));
  CHECK(found.header() == std::vector<std::string>{"id", "r_m", "mu", "mu_s", "nu", "hits_ground", "ray_680", "ray_550",
                                                   "ray_440", "mie_680", "mie_550", "mie_440"});
  REQUIRE(found.size() == table.size());
  ErrorStatistics gas("gas"), aerosol("aerosol");
  for (size_t i = 0; i < table.size(); ++i) {
    if (!by_day(table, i)) continue;
    gas.add_relative(found.rgb(i, "ray"), table.rgb(i, "ray_exact"), 1e-4);
    aerosol.add_relative(found.rgb(i, "mie"), table.rgb(i, "mie_exact"), 1e-4);
  }
  gas.check(2e-3, 1e-2);
  aerosol.check(2e-3, 1e-2);
}

TEST_CASE("irradiance by day: direct within 2e-3, sky of orders 1 to 3 with median 1.5 %, 95 % of rows 4 %") {
  const OracleTable table("ground_irradiance.csv");
  const Results found("ground_irradiance", oracle_text("ground_irradiance"), demo(3));
  CHECK(found.header() == std::vector<std::string>{"id", "r_m", "mu_s", "direct_680", "direct_550", "direct_440",
                                                   "indirect_680", "indirect_550", "indirect_440"});
  REQUIRE(found.size() == table.size());
  ErrorStatistics direct("direct"), sky("sky");
  for (size_t i = 0; i < table.size(); ++i) {
    if (!by_day(table, i)) continue;
    direct.add_relative(found.rgb(i, "direct"), table.rgb(i, "direct_exact"), 1e-3);
    sky.add_relative(found.rgb(i, "indirect"), table.rgb(i, "indirect_integrated"), 1e-3);
  }
  direct.check(2e-3, 2e-3, 2e-3);
  sky.check(1.5e-2, 4e-2);
}

TEST_CASE("sky radiance of order 1 by day: median 0.2 %, 95 % of rows 1 %; hits_ground follows from the geometry") {
  const OracleTable table("sky_radiance.csv");
  const std::string text = oracle_text("sky_radiance");
  const Results found("sky_radiance", text, demo(1));
  const std::vector<std::string> columns{"id",     "cam_x_m", "cam_y_m", "cam_z_m", "view_x",      "view_y",
                                         "view_z", "sun_x",   "sun_y",   "sun_z",   "hits_ground", "L_680",
                                         "L_550",  "L_440",   "T_680",   "T_550",   "T_440"};
  CHECK(found.header() == columns);
  REQUIRE(found.size() == table.size());
  ErrorStatistics light("order 1"), transmittance("transmittance");
  for (size_t i = 0; i < table.size(); ++i) {
    transmittance.add_absolute(found.rgb(i, "T"), table.rgb(i, "T_exact"));
    if (table.number(i, "hits_ground") > 0.5) CHECK(found.rgb(i, "T") == glm::vec3(0.0f));
    if (by_day(table, i)) light.add_relative(found.rgb(i, "L"), table.rgb(i, "L_single_exact"), 1e-3);
  }
  light.check(2e-3, 1e-2);
  transmittance.check(1e-4, 5e-4, 1e-3);

  const Results geometric("sky_radiance", drop_column(text, "hits_ground"), demo(1));
  CHECK(geometric.header().size() == columns.size() - 1);
  for (size_t i = 0; i < table.size(); ++i) CHECK(geometric.rgb(i, "L") == found.rgb(i, "L"));
}

TEST_CASE("sky radiance of 4 orders against Monte Carlo: 0.8 and 2.5 % for sun above the horizon, 8 % in twilight") {
  const OracleTable table("mc_sky_radiance.csv");
  const Results found("sky_radiance", oracle_text("mc_sky_radiance"), demo(4));
  REQUIRE(found.size() == table.size());
  ErrorStatistics day("sun above the horizon"), twilight("twilight");
  for (size_t i = 0; i < table.size(); ++i) {
    const bool up = table.number(i, "mu_s") > 0.0;
    (up ? day : twilight).add_relative(found.rgb(i, "L"), table.rgb(i, "L_mc"), up ? 1e-3 : 1e-4);
  }
  day.check(8e-3, 2.5e-2);
  twilight.check(8e-2, 8e-2);
}

TEST_CASE(
    "light up to a point, order 1, by day: median 0.3 %, 95 % of rows 2 %, worst 10 %; segments dim within 3e-3") {
  const OracleTable table("sky_radiance_to_point.csv");
  const Results found("sky_radiance_to_point", oracle_text("sky_radiance_to_point"), demo(1));
  CHECK(found.header().front() == "id");
  CHECK(found.header().at(4) == "pt_x_m");
  CHECK(found.header().back() == "T_440");
  REQUIRE(found.size() == table.size());
  ErrorStatistics light("order 1"), transmittance("of the segment");
  for (size_t i = 0; i < table.size(); ++i) {
    transmittance.add_absolute(found.rgb(i, "T"), table.rgb(i, "T_exact"));
    if (by_day(table, i)) light.add_relative(found.rgb(i, "L"), table.rgb(i, "L_single_exact"), 1e-3);
  }
  light.check(3e-3, 2e-2, 0.1);
  transmittance.check(1e-4, 1e-3, 3e-3);
}

TEST_CASE("sun and sky on a tilted plane: the sun within 2e-3 of the exact one by day") {
  const OracleTable table("sun_sky_irradiance.csv");
  const Results found("sun_sky_irradiance", oracle_text("sun_sky_irradiance"), demo(3));
  CHECK(found.header().at(4) == "n_x");
  CHECK(found.header().at(10) == "sun_680");
  CHECK(found.header().back() == "sky_440");
  REQUIRE(found.size() == table.size());
  // The sky is that of a horizontal plane, times the share of the sky that a tilted one sees.
  std::string horizontal = "r_m,mu_s\n";
  for (size_t i = 0; i < table.size(); ++i) horizontal += table.text(i, "r_m") + ',' + table.text(i, "mu_s") + '\n';
  const Results level("ground_irradiance", horizontal, demo(3));
  ErrorStatistics sun("sun"), sky("sky"), low_sky("sky, common model");
  for (size_t i = 0; i < table.size(); ++i) {
    const double up = glm::dot(table.xyz(i, "pt", "_m"), table.xyz(i, "n")) / table.number(i, "r_m");
    sky.add_relative(found.rgb(i, "sky"), glm::dvec3(level.rgb(i, "indirect")) * (0.5 + 0.5 * up), 1e-3);
    if (!by_day(table, i)) continue;
    sun.add_relative(found.rgb(i, "sun"), table.rgb(i, "sun_exact"), 1e-3);
    // Its table has texels 4 km apart, and is good near the ground only.
    if (table.number(i, "r_m") < 6361000.0) low_sky.add_relative(found.rgb(i, "sky"), table.rgb(i, "sky_lut"), 1e-3);
  }
  sun.check(2e-3, 2e-3, 2e-3);
  sky.check(1e-5, 1e-4, 1e-3);
  low_sky.check(1.5e-2, 6e-2);
}

TEST_CASE("planets of other sizes, round and flat: gas dims a vertical ray by exp(-beta H (1 - exp(-top / H)))") {
  ProbeOptions options;
  AtmosphereParams& air = options.scene.atmosphere;
  air.equatorial_radius_m = 3.0e6;
  air.polar_radius_m = 2.97e6;
  air.top_height_m = 90e3;
  air.rayleigh.scale_height_m = 11e3;
  air.rayleigh.scattering_per_m = {1e-5, 2e-5, 4e-5};
  air.mie.scattering_per_m = air.mie.extinction_per_m = glm::dvec3(0.0);
  air.ozone.column_du = 0.0;
  air.scattering_orders = 1;
  const Results table("transmittance", "r_m,mu\n3000000,1\n3011000,1\n3005000,-0.5\n", options);
  const auto to_top = [&](double from_m) {
    const double column_m = 11e3 * (std::exp(-from_m / 11e3) - std::exp(-90e3 / 11e3));
    return glm::dvec3(std::exp(-1e-5 * column_m), std::exp(-2e-5 * column_m), std::exp(-4e-5 * column_m));
  };
  // Seen from the equator and from the pole; lengths at the pole are scaled ones, a/b times as long.
  const Results sky("sky_radiance",
                    "cam_x_m,cam_y_m,cam_z_m,view_x,view_y,view_z,sun_x,sun_y,sun_z\n"
                    "0,3011000,0,0,1,0,0,0,1\n0,0,-2981000,0,0,-1,0,0,1\n0,0,2970000,0.8,0,-0.6,0,0,1\n"
                    "0,0,2969999.9999,0,0,1,0,0,1\n",
                    options);
  for (int i = 0; i < 3; ++i) {
    CHECK(table.rgb(0, "T")[i] == doctest::Approx(to_top(0.0)[i]).epsilon(5e-4));
    CHECK(table.rgb(1, "T")[i] == doctest::Approx(to_top(11000.0)[i]).epsilon(5e-4));
    CHECK(table.rgb(2, "T")[i] == 0.0);  // into the ground
    CHECK(sky.rgb(0, "T")[i] == doctest::Approx(to_top(11000.0)[i]).epsilon(5e-4));
    CHECK(sky.rgb(1, "T")[i] == doctest::Approx(to_top(11000.0)[i]).epsilon(2e-3));
    CHECK(sky.rgb(2, "T")[i] == 0.0);
    CHECK(sky.rgb(2, "L")[i] == 0.0);                                            // it stands on the ground
    CHECK(sky.rgb(3, "T")[i] == doctest::Approx(to_top(0.0)[i]).epsilon(2e-3));  // rounded to just below it
  }
}

TEST_CASE("a point at the camera is seen without air between") {
  const Results found("sky_radiance_to_point",
                      "cam_x_m,cam_y_m,cam_z_m,pt_x_m,pt_y_m,pt_z_m,sun_x,sun_y,sun_z\n"
                      "6361000,0,0,6361000,0,0,1,0,0\n",
                      demo(1));
  CHECK(found.rgb(0, "L") == glm::vec3(0.0f));
  CHECK(found.rgb(0, "T") == glm::vec3(1.0f));
}

TEST_CASE("bad rows are input errors that name line and column, before a device is looked for") {
  const std::string heights = "r_m,mu\n6360000,1\n", scattering = "r_m,mu,mu_s,nu,hits_ground\n";
  const std::string sky = "cam_x_m,cam_y_m,cam_z_m,view_x,view_y,view_z,sun_x,sun_y,sun_z,hits_ground\n";
  const std::string planes = "pt_x_m,pt_y_m,pt_z_m,n_x,n_y,n_z,sun_x,sun_y,sun_z\n";
  const struct {
    std::string kind, table, says;
  } cases[] = {
      {"transmittance", heights + "6360000,nan\n", "line 3, column 'mu': 'nan' is not a finite number"},
      {"transmittance", heights + "6360000,1.01\n", "line 3, column 'mu': 1.01 is outside -1..1"},
      {"transmittance", heights + "6359990,1\n", "line 3, column 'r_m': the point is 10 m below the ground"},
      {"transmittance", heights + "6430000,1\n", "line 3, column 'r_m': the height 70000 m is above the air"},
      {"transmittance", "r_m,mu_s\n6360000,1\n", "line 1: column 'mu' is missing"},
      {"ground_irradiance", "r_m,mu_s\n6360000,-2\n", "line 2, column 'mu_s'"},
      {"single_scattering", scattering + "6361000,0.5,0.5,-0.9,0\n", "line 2, column 'nu': -0.9 is not possible"},
      {"single_scattering", scattering + "6361000,0.5,0.5,0.25,1\n", "column 'hits_ground': 1, but the ray passes"},
      {"single_scattering", scattering + "6361000,-0.5,0.5,0,0\n", "column 'hits_ground': 0, but the ray goes"},
      {"single_scattering", scattering + "6361000,-0.5,0.5,0,2\n", "column 'hits_ground': 2 is neither 0 nor 1"},
      {"sky_radiance", sky + "6361000,0,0,0,0,0,1,0,0,0\n", "line 2, column 'view_x': the vector view_x, _y, _z has"},
      {"sky_radiance", sky + "6361000,0,0,1,0,0,2,0,0,0\n", "column 'sun_x': the vector"},
      {"sky_radiance", sky + "0,0,0,1,0,0,1,0,0,0\n", "line 2, column 'cam_x_m': the point is 6.36e+06 m below"},
      {"sky_radiance", sky + "1e15,0,0,1,0,0,1,0,0,0\n", "column 'cam_x_m': the point is 1e+15 m away"},
      {"sky_radiance", sky + "6361000,0,0,1,0,0,1,0,0,1\n", "column 'hits_ground': 1, but the ray passes 1000 m"},
      {"sky_radiance_to_point",
       "cam_x_m,cam_y_m,cam_z_m,pt_x_m,pt_y_m,pt_z_m,sun_x,sun_y,sun_z\n6361000,0,0,-6361000,0,0,1,0,0\n",
       "line 2, column 'pt_x_m': the point is hidden: the way to it goes 6.36e+06 m under the ground"},
      {"sun_sky_irradiance", planes + "6361000,0,0,1,1,0,1,0,0\n", "line 2, column 'n_x'"},
      {"sun_sky_irradiance", planes + "6361000,,0,1,0,0,1,0,0\n", "column 'pt_y_m': the cell is empty"}};
  for (const auto& c : cases) {
    CAPTURE(c.table);
    const Error e = probe_error(c.kind, c.table);
    CHECK(e.kind() == ErrorKind::input);
    CHECK_MESSAGE(std::string(e.what()).find(c.says) != std::string::npos, e.what());
  }
}

TEST_CASE("without its device a probe of the air is status 4; air that cannot be is a usage error") {
  const Error e = probe_error("transmittance", "r_m,mu\n6360000,1\n");
  CHECK(e.exit_status() == 4);
  ProbeOptions options = demo(4);
  options.scene.atmosphere.mie.visibility_m = 1e9;
  std::istringstream in("r_m,mu\n");
  std::ostringstream out;
  CHECK_THROWS_WITH_AS(run_probe("transmittance", in, out, options),
                       doctest::Contains("atmosphere.mie.visibility_m: 1000000000 m is more than gas alone"), Error);
}
