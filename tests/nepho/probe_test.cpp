#include "probe.h"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <sstream>

#include "base/error.h"
#include "base/files.h"
#include "oracles/oracle_table.h"
#include "probe_tables.h"
#include "weather/weather_map.h"

using namespace nepho;

namespace {

std::string oracle_text(const std::string& name) { return read_text_file(test::oracle_path(name + ".csv")); }

std::string probe(const std::string& kind, const std::string& table) {
  std::istringstream in(table);
  std::ostringstream out;
  CHECK(run_probe(kind, in, out) == 0);
  return out.str();
}

/// The error of a probe that must fail and must have written nothing.
Error probe_error(const std::string& kind, const std::string& table) {
  std::istringstream in(table);
  std::ostringstream out;
  try {
    run_probe(kind, in, out);
  } catch (const Error& e) {
    CHECK(out.str().empty());
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    return e;
  }
  FAIL("no error from: " << table);
  return Error(ErrorKind::failure, "");
}

bool mentions(const Error& e, const std::string& text) { return std::string(e.what()).find(text) != std::string::npos; }

std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::istringstream in(csv);
  const auto records = read_csv(in);
  std::vector<std::map<std::string, std::string>> rows;
  for (size_t r = 1; r < records.size(); ++r) {
    std::map<std::string, std::string> row;
    for (size_t i = 0; i < records[0].cells.size(); ++i) row[records[0].cells[i]] = records[r].cells.at(i);
    rows.push_back(row);
  }
  return rows;
}

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

/// Feeds a whole oracle table to the probe and compares every result column, within `tolerance(column, row)`.
template <typename F>
void check_against_oracle(const std::string& kind, const F& tolerance) {
  CAPTURE(kind);
  const auto expected = rows_of(oracle_text(kind));
  const auto actual = rows_of(probe(kind, oracle_text(kind)));
  REQUIRE(actual.size() == expected.size());
  for (size_t r = 0; r < actual.size(); ++r) {
    CAPTURE(expected[r].at("id"));
    CHECK(actual[r].size() >= expected[r].size() - 1);  // all columns but `category`, which is no input
    for (const auto& [name, text] : expected[r]) {
      if (name == "category") continue;
      CAPTURE(name);
      REQUIRE(actual[r].count(name) == 1);
      if (actual[r].at(name) == text) continue;  // inputs are repeated as they were
      const double limit = tolerance(name, expected[r]);
      double error = number(actual[r].at(name)) - number(text);
      if (name.find("lon") != std::string::npos || name.find("az") != std::string::npos || name == "gast_deg")
        error = std::remainder(error, 360.0);
      CHECK(std::abs(error) <= limit);
    }
  }
}

using Row = std::map<std::string, std::string>;

}  // namespace

TEST_CASE("probes reproduce the geodesy tables at their stated tolerances") {
  check_against_oracle("geodetic_ecef", [](const std::string&, const Row&) { return 1e-6; });
  check_against_oracle("ecef_to_geodetic", [](const std::string& name, const Row& row) {
    if (name == "height_m") return 1e-6;
    return row.at("category") == "deep_inside"                                  ? 1e-9
           : name == "lon_deg" && std::abs(number(row.at("lat_deg"))) > 89.9999 ? 360.0
                                                                                : 1e-11;
  });
  check_against_oracle("enu_frames",
                       [](const std::string& name, const Row&) { return name.starts_with("target") ? 1e-6 : 1e-12; });
  check_against_oracle("geodesic_inverse", [](const std::string& name, const Row& row) {
    const std::string& category = row.at("category");
    const bool ill = category == "near_antipodal" || category == "polar" || category == "short";
    if (name == "s12_m") return 1e-5;
    // Ill-conditioned directions and quarter points are checked by distances in tests/geo/geodesic_test.cpp.
    if (category == "near_antipodal" && name != "a12_deg") return 360.0;
    if (name.starts_with("azi")) return ill ? 360.0 : 1e-9;
    const bool near_pole = name.ends_with("lon_deg") && category == "polar";
    return near_pole ? 1e-6 : 1e-9;
  });
  check_against_oracle("geodesic_direct", [](const std::string& name, const Row& row) {
    const bool near_pole = std::abs(number(row.at("lat2_deg"))) > 89.9;
    return near_pole && name != "lat2_deg" ? 360.0 : 1e-9;
  });
  check_against_oracle("geoid_egm96",
                       [](const std::string& name, const Row&) { return name == "N_bilinear15_m" ? 1e-6 : 1e-3; });
}

TEST_CASE("the ephemeris probe reproduces its table at 5 and 20 arc seconds") {
  check_against_oracle("ephemeris", [](const std::string& name, const Row& row) {
    const double moon = 20.0 / 206265.0, sun = 5.0 / 206265.0;
    if (name == "jd_ut") return 1e-8;
    if (name == "gast_deg") return 0.5 / 3600.0;
    if (name == "sun_dist_au") return 1e-4;
    if (name.ends_with("dist_km")) return 2e-4 * number(row.at(name));
    if (name.ends_with("ang_radius_deg")) return 2e-4 * 0.27;
    if (name == "moon_illuminated_fraction") return 1e-3;
    if (name == "moon_phase_angle_deg" || name == "moon_ecl_elongation_deg") return 0.01;
    if (name == "sun_az_deg") return 15.0 / 3600.0 / std::cos(number(row.at("sun_elev_deg")) * 3.14159265 / 180.0);
    if (name == "moon_topo_az_deg")
      return 20.0 / 3600.0 / std::cos(number(row.at("moon_topo_elev_deg")) * 3.14159265 / 180.0);
    if (name == "sun_elev_deg") return 15.0 / 3600.0;
    if (name == "moon_topo_elev_deg") return 20.0 / 3600.0;
    return name.starts_with("moon") ? moon : sun;
  });
}

TEST_CASE(
    "from the time alone the sun is within 5, the moon within 20 arc seconds before 2026, its lit share within 1e-3") {
  const auto expected = rows_of(oracle_text("ephemeris"));
  std::string times = "id,utc\n";
  for (const Row& row : expected) times += row.at("id") + ',' + row.at("utc") + '\n';
  const auto actual = rows_of(probe("ephemeris", times));
  REQUIRE(actual.size() == expected.size());
  const auto direction = [](const Row& row, const std::string& body) {
    return glm::dvec3(number(row.at(body + "_x")), number(row.at(body + "_y")), number(row.at(body + "_z")));
  };
  int early = 0;
  for (size_t r = 0; r < actual.size(); ++r) {
    CAPTURE(expected[r].at("utc"));
    CHECK(std::abs(number(actual[r].at("moon_illuminated_fraction")) -
                   number(expected[r].at("moon_illuminated_fraction"))) < 1e-3);
    if (expected[r].at("utc") >= "2026") continue;
    ++early;
    const auto apart_arcsec = [&](const std::string& body) {
      const glm::dvec3 a = direction(actual[r], body), b = direction(expected[r], body);
      return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 206264.806;
    };
    CHECK(apart_arcsec("sun") < 5.0);
    CHECK(apart_arcsec("moon") < 20.0);
  }
  CHECK(early > 100);
}

TEST_CASE("columns are found by name in any order, others are dropped, inputs come back as they were") {
  CHECK(probe("geodetic_ecef", "height_m,remark,lon_deg,id,lat_deg\n0,x,00.0,\"a,\"\"b\",+0\n") ==
        "id,lat_deg,lon_deg,height_m,x_m,y_m,z_m\n\"a,\"\"b\",+0,00.0,0,6378137,0,0\n");
  CHECK(probe("geodetic_ecef", "lat_deg,lon_deg,height_m\n0,0,0\n") ==
        "lat_deg,lon_deg,height_m,x_m,y_m,z_m\n0,0,0,6378137,0,0\n");
}

TEST_CASE("CRLF, blank lines, quotes, spaces, a byte order mark and a missing last newline make no difference") {
  const std::string plain = probe("geoid_egm96", "lat_deg,lon_deg\n10,20\n30,40\n");
  CHECK(probe("geoid_egm96", "\xEF\xBB\xBF\"lat_deg\", lon_deg\r\n\r\n10,\"20\"\r\n   \n30 ,40") == plain);
  CHECK(rows_of(plain).size() == 2);
}

TEST_CASE("a header without rows gives a header, for every kind") {
  CHECK(probe("geodetic_ecef", "lat_deg,lon_deg,height_m\n") == "lat_deg,lon_deg,height_m,x_m,y_m,z_m\n");
  const std::map<std::string, std::string> headers{
      {"terrain", "lat_deg,lon_deg,height_m,height_msl_m,slope_deg,source\n"},
      {"pick", "x_px,y_px,lat_deg,lon_deg,height_m,distance_m,hit\n"},
      {"weather",
       "lat_deg,lon_deg,coverage_r,coverage_g,coverage_b,coverage_a,type,base_offset_m,density_factor,precipitation\n"},
      {"density", "lat_deg,lon_deg,height_m,density_r,density_g,density_b,density_a,extinction_per_m\n"},
      {"column",
       "lat_deg,lon_deg,optical_depth_r,optical_depth_g,optical_depth_b,optical_depth_a,optical_depth,base_m,top_m\n"}};
  for (const std::string& kind : probe_kind_names()) {
    CAPTURE(kind);
    if (headers.count(kind) > 0) {
      CHECK(probe(kind, "height_m,lon_deg,lat_deg,y_px,x_px\n") == headers.at(kind));
      continue;
    }
    const std::string text = oracle_text(kind == "slab" ? "slab_dev" : kind);
    CHECK(rows_of(probe(kind, text.substr(0, text.find('\n') + 1))).empty());
  }
}

TEST_CASE("terrain without rasters is the ellipsoid; a place outside the picture cannot be picked") {
  const auto rows = rows_of(probe("terrain", "lat_deg,lon_deg\n35,139\n-90,0\n"));
  for (const auto& row : rows) {
    CHECK(std::abs(std::stod(row.at("height_m"))) < 1e-3);  // at the pole the mesh is coarse
    CHECK(std::stod(row.at("slope_deg")) < 0.1);
    CHECK(row.at("source") == "ellipsoid");
  }
  std::istringstream in("x_px,y_px\n1,1\n641,0\n");
  std::ostringstream out;
  try {
    run_probe("pick", in, out);
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()).find("line 3, column 'x_px': 641 is outside the picture, 0..640") != std::string::npos);
  }
  CHECK(out.str().empty());
}

TEST_CASE("optional inputs may be absent or blank; half a group is an error") {
  const auto rows =
      rows_of(probe("ephemeris", "utc,obs_lat_deg,obs_lon_deg,obs_height_m\n2026-06-20,35,139,0\n2026-06-20,,,\n"));
  CHECK_FALSE(rows[0].at("sun_elev_deg").empty());
  CHECK(rows[1].at("sun_elev_deg").empty());
  CHECK(rows[1].at("sun_x") == rows[0].at("sun_x"));
  CHECK(number(rows[0].at("tt_minus_ut_s")) == doctest::Approx(69.184));
  CHECK(rows_of(probe("ephemeris", "utc\n2026-06-20\n"))[0].count("sun_elev_deg") == 0);
  CHECK(mentions(probe_error("ephemeris", "utc,obs_lat_deg\n2026-06-20,35\n"), "'obs_lon_deg' is missing"));
  const Error blank = probe_error("ephemeris", "utc,obs_lat_deg,obs_lon_deg,obs_height_m\n2026-06-20,35,,0\n");
  CHECK(mentions(blank, "line 2, column 'obs_lon_deg'"));
  CHECK(rows_of(probe("enu_frames", "lat_deg,lon_deg,height_m\n0,0,0\n"))[0].count("target_e_m") == 0);
}

TEST_CASE("a missing column or a bad value is an input error that names line and column") {
  const std::string header = "id,lat_deg,lon_deg,height_m\n";
  const struct {
    std::string table, says;
  } cases[] = {
      {header + "1,10,20,30\n\n2,10,abc,30\n", "line 4, column 'lon_deg': 'abc'"},
      {header + "1,nan,20,30\n", "line 2, column 'lat_deg': 'nan' is not a finite number"},
      {header + "1,10,inf,30\n", "'inf' is not a finite number"},
      {header + "1,10,1e999,30\n", "'1e999' is not a finite number"},
      {header + "1,91,20,30\n", "column 'lat_deg': 91 is outside -90..90"},
      {header + "1,10,,30\n", "line 2, column 'lon_deg': the cell is empty"},
      {header + "1,10,20 30,30\n", "'20 30'"},
      {header + "1,10,0x20,30\n", "'0x20'"},
      {header + "1,10,+-20,30\n", "'+-20'"},
      {header + "1,10,20\n", "line 2: 3 cells where the header has 4 (column 'height_m' is missing)"},
      {header + "1,10,20,30,40\n", "line 2: 5 cells where the header has 4"},
      {"id,lat,lon_deg,height_m\n1,2,3,4\n", "line 1: column 'lat_deg' is missing (found: id, lat, lon_deg, height_m)"},
      {"lat_deg,lat_deg,lon_deg,height_m\n1,1,2,3\n", "column 'lat_deg' is there twice"},
      {header + "1,10,20,\"30\n", "line 2: a double quote is never closed"},
      {header + "1,10,\"20\"x,30\n", "line 2: 'x' follows"},
      {"", "the table is empty"},
      {"\n \n", "the table is empty"}};
  for (const auto& c : cases) {
    CAPTURE(c.table);
    const Error e = probe_error("geodetic_ecef", c.table);
    CAPTURE(e.what());
    CHECK(e.kind() == ErrorKind::input);
    CHECK(mentions(e, c.says));
  }
  for (const char* utc : {"1899-12-31", "2101-01-01", "yesterday", "2026-02-30"}) {
    const Error e = probe_error("ephemeris", std::string("utc\n2026-01-01\n") + utc + "\n");
    CHECK(e.kind() == ErrorKind::input);
    CHECK(mentions(e, "line 3, column 'utc'"));
  }
}

TEST_CASE("line numbers count lines inside quoted cells") {
  const Error e = probe_error("geoid_egm96", "note,lat_deg,lon_deg\n\"two\nlines\",1,2\nx,1,bad\n");
  CHECK(mentions(e, "line 4, column 'lon_deg'"));
}

TEST_CASE("an unknown kind is a usage error that names the nearest and all known kinds") {
  const Error e = probe_error("geodetic_ecf", "");
  CHECK(e.kind() == ErrorKind::usage);
  CHECK(mentions(e, "did you mean 'geodetic_ecef'"));
  for (const char* kind :
       {"geodetic_ecef", "ecef_to_geodetic", "enu_frames", "geodesic_inverse", "geodesic_direct", "geoid_egm96",
        "ephemeris", "transmittance", "single_scattering", "ground_irradiance", "sky_radiance", "sky_radiance_to_point",
        "sun_sky_irradiance", "weather", "density", "column"})
    CHECK(mentions(e, kind));
}

TEST_CASE(
    "a bad row of a table of clouds is an input error with line and column, before any device or file is opened") {
  const struct {
    const char *kind, *table, *says;
  } cases[] = {
      {"weather", "lat_deg,lon_deg\n0,0\n-90.5,0\n", "line 3, column 'lat_deg': -90.5 is outside -90..90"},
      {"weather", "lat_deg\n0\n", "column 'lon_deg' is missing"},
      {"density", "lat_deg,lon_deg\n0,0\n", "column 'height_m' is missing"},
      {"density", "lat_deg,lon_deg,height_m\n0,nan,0\n", "line 2, column 'lon_deg': 'nan' is not a finite number"},
      {"density", "lat_deg,lon_deg,height_m\n0,0,2e9\n",
       "line 2, column 'height_m': 2000000000 is outside -12000..1000000000"},
      {"density", "lat_deg,lon_deg,height_m\n0,0,\n", "line 2, column 'height_m': the cell is empty"},
      {"density", "lat_deg,lon_deg,height_m,camera_lat_deg\n0,0,0,0\n", "column 'camera_lon_deg' is missing"},
      {"density", "lat_deg,lon_deg,height_m,camera_lat_deg,camera_lon_deg,camera_height_m\n0,0,0,0,0,-13000\n",
       "line 2, column 'camera_height_m': -13000 is outside"},
      {"density", "lat_deg,lon_deg,height_m,camera_lat_deg,camera_lon_deg,camera_height_m\n0,0,0,91,0,0\n",
       "line 2, column 'camera_lat_deg': 91 is outside -90..90"},
      {"column", "lat_deg,lon_deg,footprint_m\n0,0,-1\n", "line 2, column 'footprint_m': -1 is outside 0..10000000"},
      {"column", "lat_deg,lon_deg,time\n0,0,2026-01-01\n0,0,noon\n", "line 3, column 'time': time 'noon'"},
      {"column", "lat_deg,lon_deg,time\n0,0,2101-01-01\n", "is outside 1900..2100"}};
  for (const auto& c : cases) {
    CAPTURE(c.table);
    const Error e = probe_error(c.kind, c.table);
    CAPTURE(e.what());
    CHECK(e.kind() == ErrorKind::input);
    CHECK(mentions(e, c.says));
  }
}

TEST_CASE("weather files are opened before a device is asked for, and only for kinds that look at clouds") {
  int opened = 0;
  ProbeOptions options;
  options.device = "no such device";
  options.open_weather = [&](const Scene&) -> WeatherSources {
    ++opened;
    throw fail(ErrorKind::input, "w.tif: not weather");
  };
  std::istringstream in("lat_deg,lon_deg\n1,2\n"), again("lat_deg,lon_deg\n1,2\n");
  std::ostringstream out;
  CHECK(run_probe("geoid_egm96", in, out, options) == 0);
  CHECK(opened == 0);
  try {
    run_probe("column", again, out, options);
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()) == "w.tif: not weather");
  }
  CHECK(opened == 1);
}

TEST_CASE("results have 17 significant digits: they come back as the same numbers") {
  const auto rows = rows_of(probe("geodetic_ecef", "lat_deg,lon_deg,height_m\n35.1,138.7,12.5\n0,90,1e-7\n"));
  CHECK(rows[0].at("x_m") == fmt::format("{:.17g}", number(rows[0].at("x_m"))));
  CHECK(rows[1].at("y_m") == "6378137.0000000997");
}

TEST_CASE("an output that cannot be written is a failure") {
  std::istringstream in("lat_deg,lon_deg\n1,2\n");
  std::ofstream full("/dev/full");
  try {
    run_probe("geoid_egm96", in, full);
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::failure);
  }
}
