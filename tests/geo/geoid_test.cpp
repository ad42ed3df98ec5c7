#include "geo/geoid.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "geo/geodetic.h"
#include "oracles/oracle_table.h"

using namespace nepho;
using nepho::test::oracle_table;

TEST_CASE("EGM96 undulations agree with the table: 1 um bilinear, 1 mm bicubic") {
  const Geoid& geoid = Geoid::egm96();
  REQUIRE_MESSAGE(geoid.available(), geoid.problem());
  const auto rows = oracle_table("geoid_egm96");
  REQUIRE(rows.size() >= 80);
  for (const auto& row : rows) {
    CAPTURE(row.id());
    const double lat = rad_from_deg(row.number("lat_deg")), lon = rad_from_deg(row.number("lon_deg"));
    CHECK(std::abs(geoid.undulation_m(lat, lon) - row.number("N_bilinear15_m")) < 1e-6);
    CHECK(std::abs(geoid.undulation_bicubic_m(lat, lon) - row.number("N_bicubic15_m")) < 1e-3);
  }
}

TEST_CASE("the geoid is continuous over the antimeridian, and single-valued at the poles") {
  const Geoid& g = Geoid::egm96();
  for (double lat : {-1.2, 0.0, 0.7}) {
    CHECK(std::abs(g.undulation_m(lat, rad_from_deg(179.9999999)) - g.undulation_m(lat, rad_from_deg(-180.0))) < 1e-5);
    CHECK(g.undulation_m(lat, rad_from_deg(540.0)) == doctest::Approx(g.undulation_m(lat, rad_from_deg(180.0))));
  }
  for (double lon : {-3.0, 0.0, 2.0}) CHECK(std::abs(g.undulation_m(std::numbers::pi / 2, lon) - 13.606) < 1e-3);
}

TEST_CASE("without its file, or with a broken one, the geoid is 0 and says why") {
  namespace fs = std::filesystem;
  const Geoid absent{fs::path()};
  CHECK_FALSE(absent.available());
  CHECK(absent.undulation_m(0.5, 0.5) == 0.0);
  CHECK(absent.undulation_bicubic_m(0.5, 0.5) == 0.0);
  CHECK(absent.problem().find("egm96_15.gtx") != std::string::npos);

  const fs::path broken = fs::temp_directory_path() / "nepho_geoid_test.gtx";
  std::ifstream in(Geoid::find_egm96(), std::ios::binary);
  std::string bytes(5000, '\0');
  in.read(bytes.data(), 5000);
  for (const size_t size : {size_t{0}, size_t{39}, size_t{5000}}) {
    std::ofstream(broken, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(size));
    const Geoid geoid(broken);
    CHECK_FALSE(geoid.available());
    CHECK(geoid.problem().find("nepho_geoid_test.gtx") != std::string::npos);
  }
  fs::remove(broken);
}
