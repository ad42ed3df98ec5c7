#include "scene/atmosphere_params.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "base/error.h"

using namespace nepho;

namespace {

/// The message of the usage error that resolving the Earth's air, changed, ends with.
template <typename F>
std::string refused(const F& change) {
  AtmosphereParams air = AtmosphereParams::earth();
  change(air);
  try {
    resolved(air);
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::usage);
    const auto problem = find_problem(air);
    REQUIRE(problem.has_value());
    CHECK(std::string(e.what()) == "atmosphere." + problem->member + ": " + problem->reason);
    return e.what();
  }
  CHECK_FALSE(find_problem(air).has_value());
  return "accepted";
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void check_close(const glm::dvec3& a, const glm::dvec3& b) {
  for (int i = 0; i < 3; ++i) CHECK(a[i] == doctest::Approx(b[i]).epsilon(1e-12));
}

}  // namespace

TEST_CASE("presets are found by name; the Earth is WGS84 with air to 100 km, the demo a sphere of 6360 km with 60 km") {
  REQUIRE(atmosphere_preset_names().size() == 2);
  for (const std::string& name : atmosphere_preset_names()) {
    REQUIRE(atmosphere_preset(name).has_value());
    CHECK_FALSE(find_problem(*atmosphere_preset(name)).has_value());
  }
  CHECK_FALSE(atmosphere_preset("mars").has_value());
  const AtmosphereParams earth = *atmosphere_preset("earth"), demo = *atmosphere_preset("bruneton-demo");
  CHECK(earth.equatorial_radius_m == 6378137.0);
  CHECK(earth.polar_radius_m == doctest::Approx(6356752.314245).epsilon(1e-13));
  CHECK(earth.top_height_m == 100000.0);
  CHECK(demo.equatorial_radius_m == 6360000.0);
  CHECK(demo.polar_radius_m == 6360000.0);
  CHECK(demo.top_height_m == 60000.0);
  // The extinction of the demo is 5.328e-3 / 1200 m, nine tenths of it scattering (shared oracles).
  check_close(demo.mie.extinction_per_m, glm::dvec3(5.328e-3 / 1200.0));
  check_close(demo.mie.scattering_per_m, glm::dvec3(0.9 * 5.328e-3 / 1200.0));
}

TEST_CASE("air with nothing to resolve stays as it is, bit for bit, and resolving twice changes nothing") {
  CHECK(resolved(AtmosphereParams::earth()) == AtmosphereParams::earth());
  AtmosphereParams air;
  air.mie.optical_depth = 0.12345;
  air.ozone.column_du = 321.0;
  CHECK(resolved(resolved(air)) == resolved(air));
  air.mie.optical_depth.reset();
  air.mie.visibility_m = 12345.0;
  CHECK(resolved(resolved(air)) == resolved(air));
  CHECK_FALSE(resolved(air).mie.visibility_m.has_value());
  CHECK_FALSE(resolved(air).ozone.column_du.has_value());
}

TEST_CASE("an aerosol optical depth is extinction at 550 nm times scale height; spectrum and albedo stay") {
  AtmosphereParams air;
  air.mie.scale_height_m = 2000.0;
  air.mie.optical_depth = 0.5;
  const MieParams mie = resolved(air).mie;
  CHECK(mie.extinction_per_m[1] * 2000.0 == doctest::Approx(0.5).epsilon(1e-12));
  check_close(mie.extinction_per_m / mie.extinction_per_m[1], air.mie.extinction_per_m / air.mie.extinction_per_m[1]);
  check_close(mie.scattering_per_m / mie.extinction_per_m, air.mie.scattering_per_m / air.mie.extinction_per_m);
  air.mie.optical_depth = 0.0;
  CHECK(resolved(air).mie.extinction_per_m == glm::dvec3(0.0));
  // The defaults say that they are a depth of 0.03.
  AtmosphereParams standard;
  standard.mie.optical_depth = 0.03;
  check_close(resolved(standard).mie.extinction_per_m, MieParams{}.extinction_per_m);
}

TEST_CASE("a visibility is Koschmieder's: gas and aerosol at 550 nm dim a contrast to 2 % over it") {
  AtmosphereParams air;
  for (const double visibility_m : {500.0, 23000.0, 200000.0}) {
    air.mie.visibility_m = visibility_m;
    const AtmosphereParams r = resolved(air);
    CHECK(std::exp(-(r.mie.extinction_per_m[1] + r.rayleigh.scattering_per_m[1]) * visibility_m) ==
          doctest::Approx(0.02).epsilon(1e-3));
    check_close(r.mie.scattering_per_m / r.mie.extinction_per_m, air.mie.scattering_per_m / air.mie.extinction_per_m);
  }
  // Clean continental air: about 100 km (MieParams).
  CHECK(3.912 / (air.mie.extinction_per_m[1] + air.rayleigh.scattering_per_m[1]) ==
        doctest::Approx(100e3).epsilon(0.05));
}

TEST_CASE("300 Dobson units are the default absorption; half the width, or half the column in the air, doubles it") {
  AtmosphereParams air;
  air.ozone.column_du = 300.0;
  check_close(resolved(air).ozone.absorption_per_m, OzoneParams{}.absorption_per_m);
  air.ozone.half_width_m = 7500.0;
  check_close(resolved(air).ozone.absorption_per_m, 2.0 * OzoneParams{}.absorption_per_m);
  air.ozone.half_width_m = 15000.0;
  air.ozone.center_m = 0.0;  // its lower half would be below the ground
  check_close(resolved(air).ozone.absorption_per_m, 2.0 * OzoneParams{}.absorption_per_m);
  air.ozone.center_m = 7500.0;  // 1/8 of the tent is below the ground
  check_close(resolved(air).ozone.absorption_per_m, OzoneParams{}.absorption_per_m / 0.875);
  air.ozone.column_du = 0.0;
  CHECK(resolved(air).ozone.absorption_per_m == glm::dvec3(0.0));
}

TEST_CASE("contradictions are errors that name the parameter") {
  using A = AtmosphereParams;
  CHECK(refused([](A&) {}) == "accepted");
  CHECK(refused([](A& a) { a.mie.optical_depth = a.mie.visibility_m = 1.0; }).find("keep one of the two") !=
        std::string::npos);
  CHECK(refused([](A& a) { a.mie.visibility_m = 288544.0; }).find("at most 288543 m") != std::string::npos);
  CHECK(refused([](A& a) { a.mie.visibility_m = 288543.0; }) == "accepted");
  const auto no_aerosol = [](A& a) {
    a.mie.extinction_per_m = a.mie.scattering_per_m = glm::dvec3(0.0);
    a.mie.optical_depth = 0.1;
  };
  CHECK(refused(no_aerosol).find("no spectrum to scale") != std::string::npos);
  const auto no_room = [](A& a) {
    a.ozone.center_m = 200e3;
    a.ozone.column_du = 300.0;
  };
  CHECK(refused(no_room).find("no room for ozone") != std::string::npos);
  CHECK(refused([](A& a) { a.polar_radius_m = 3.0e6; }).find("less than half of equatorial") != std::string::npos);
  CHECK(refused([](A& a) { a.top_height_m = 3.2e6; }).find("more than half of equatorial") != std::string::npos);
}

TEST_CASE("the air reaches up to 3 scale heights at least, and is not more opaque than 100 vertical optical depths") {
  using A = AtmosphereParams;
  CHECK(refused([](A& a) { a.top_height_m = 24000.0; }) == "accepted");
  CHECK(refused([](A& a) { a.top_height_m = 23999.0; }).find("too thin") != std::string::npos);
  CHECK(refused([](A& a) { a.mie.scale_height_m = 33400.0; }).find("mie.scale_height_m 33400") != std::string::npos);
  CHECK(refused([](A& a) { a.mie.optical_depth = 99.0; }).find("mie.optical_depth: gives") != std::string::npos);
  CHECK(refused([](A& a) { a.mie.optical_depth = 70.0; }) == "accepted");
  CHECK(refused([](A& a) { a.ozone.column_du = 2e6; }).find("ozone.column_du: gives the air") != std::string::npos);
  CHECK(refused([](A& a) { a.ozone.absorption_per_m[2] = 0.1; }).find("ozone.absorption_per_m[2]: gives the air") !=
        std::string::npos);
}

TEST_CASE("a NaN is refused wherever it is") {
  using A = AtmosphereParams;
  CHECK(refused([](A& a) { a.top_height_m = kNan; }) != "accepted");
  CHECK(refused([](A& a) { a.polar_radius_m = kNan; }) != "accepted");
  CHECK(refused([](A& a) { a.rayleigh.scale_height_m = kNan; }) != "accepted");
  CHECK(refused([](A& a) { a.rayleigh.scattering_per_m[2] = kNan; }).find("rayleigh.scattering_per_m[2]") !=
        std::string::npos);
  CHECK(refused([](A& a) { a.mie.scattering_per_m[0] = kNan; }) != "accepted");
  CHECK(refused([](A& a) { a.mie.extinction_per_m[0] = kNan; }) != "accepted");
  CHECK(refused([](A& a) { a.mie.optical_depth = kNan; }).find("mie.optical_depth") != std::string::npos);
  CHECK(refused([](A& a) { a.mie.visibility_m = kNan; }).find("mie.visibility_m") != std::string::npos);
  CHECK(refused([](A& a) { a.ozone.column_du = kNan; }).find("ozone.column_du") != std::string::npos);
  CHECK(refused([](A& a) { a.ozone.absorption_per_m[1] = kNan; }).find("ozone.absorption_per_m[1]") !=
        std::string::npos);
  CHECK(refused([](A& a) { a.ozone.half_width_m = kNan; }) != "accepted");
}
