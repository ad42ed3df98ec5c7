#include "astro/star_catalog.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "astro/spectral_color.h"
#include "base/error.h"

using namespace nepho;
namespace fs = std::filesystem;

namespace {

fs::path installed() {
  for (const char* root : {"/usr/local/share", "/usr/share"})
    if (fs::is_regular_file(fs::path(root) / "marble/data/stars/stars.dat"))
      return fs::path(root) / "marble/data/stars/stars.dat";
  return {};
}

const Star& star(const std::vector<Star>& stars, int hr) {
  for (const Star& s : stars)
    if (s.hr == hr) return s;
  FAIL("no star HR " << hr);
  return stars.front();
}

dvec3 direction(double ra_h, double ra_m, double ra_s, double dec_deg) {
  const double ra = rad_from_deg(15.0 * (ra_h + ra_m / 60.0 + ra_s / 3600.0)), dec = rad_from_deg(dec_deg);
  return {std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec)};
}

double arcsec_between(const dvec3& a, const dvec3& b) {
  return deg_from_rad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))) * 3600.0;
}

/// A damaged catalogue in a file of its own.
struct TemporaryFile {
  fs::path path = fs::temp_directory_path() / ("nepho_stars_" + std::to_string(std::rand()) + ".dat");
  explicit TemporaryFile(const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
  ~TemporaryFile() { fs::remove(path); }
};

std::string reason(const fs::path& path) {
  try {
    read_star_catalog(path);
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    CHECK(std::string(e.what()).find(path.string()) != std::string::npos);
    return e.what();
  }
  return "";
}
bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

// One star at RA 1 rad, declination 0.5 rad, V = 1.0, colour 2.
std::string one_star() {
  using namespace std::string_literals;
  return "star\0\0\0\4"s + "\0\0\0\7"s + "\x3f\xf0\0\0\0\0\0\0"s + "\x3f\xe0\0\0\0\0\0\0"s + "\x3f\xf0\0\0\0\0\0\0"s +
         "\0\0\0\2"s;
}

}  // namespace

TEST_CASE("stars: Sirius, Vega and Polaris stand where they stood at J2000, as bright as they are") {
  if (installed().empty()) {
    MESSAGE("skipped: the package marble-qt-data is not installed");
    return;
  }
  const std::vector<Star> stars = read_star_catalog(installed());
  CHECK(stars.size() == 5022);
  struct Known {
    int hr;
    dvec3 dir;
    double magnitude;
  };
  // SIMBAD, J2000.
  for (const Known& k : {Known{2491, direction(6, 45, 8.92, -(16 + 42 / 60.0 + 58.0 / 3600)), -1.46},
                         Known{7001, direction(18, 36, 56.34, 38 + 47 / 60.0 + 1.3 / 3600), 0.03},
                         Known{424, direction(2, 31, 49.09, 89 + 15 / 60.0 + 50.8 / 3600), 2.02}}) {
    const Star& s = star(stars, k.hr);
    CAPTURE(k.hr);
    CHECK(arcsec_between(s.dir_icrs, k.dir) < 8.0);  // whole seconds of right ascension are 15 arc seconds apart
    CHECK(s.magnitude == doctest::Approx(k.magnitude));
  }
  for (const Star& s : stars) {
    CHECK(std::abs(glm::length(s.dir_icrs) - 1.0) < 1e-12);
    CHECK(0.2126f * s.color.x + 0.7152f * s.color.y + 0.0722f * s.color.z == doctest::Approx(1.0f).epsilon(1e-4));
    CHECK(std::min({s.color.x, s.color.y, s.color.z}) > 0.0f);
  }
}

TEST_CASE("stars: Spica is bluer than Vega, Vega than Capella, Capella than Aldebaran, that than Betelgeuse") {
  if (installed().empty()) {
    MESSAGE("skipped: the package marble-qt-data is not installed");
    return;
  }
  const std::vector<Star> stars = read_star_catalog(installed());
  float before = 0.0f;
  for (const int hr : {5056, 7001, 1708, 1457, 2061}) {
    const vec3 c = star(stars, hr).color;
    CAPTURE(hr);
    CHECK(c.x / c.z > before);
    before = c.x / c.z;
  }
}

TEST_CASE("stars: damaged and missing catalogues are told in one line") {
  CHECK(has(reason("/nowhere/stars.dat"), "marble-qt-data"));
  CHECK(has(reason(TemporaryFile("").path), "'star'"));
  CHECK(has(reason(TemporaryFile("stat\0\0\0\4").path), "'star'"));
  const TemporaryFile good(one_star());
  CHECK(read_star_catalog(good.path).size() == 1);
  CHECK(read_star_catalog(good.path)[0].hr == 7);
  CHECK(arcsec_between(read_star_catalog(good.path)[0].dir_icrs,
                       dvec3(std::cos(0.5) * std::cos(1.0), std::cos(0.5) * std::sin(1.0), std::sin(0.5))) < 7.0);
  const std::string bytes = one_star();
  const TemporaryFile cut(bytes.substr(0, 39)), empty(bytes.substr(0, 8));
  CHECK(has(reason(cut.path), "cut short"));
  CHECK(has(reason(empty.path), "cut short"));
  std::string changed = bytes;
  changed[7] = 3;
  const TemporaryFile version(changed);
  CHECK(has(reason(version.path), "version 3"));
  changed = bytes;
  changed[39] = 9;
  const TemporaryFile colour(changed);
  CHECK(has(reason(colour.path), "colour 9"));
  changed = bytes;
  changed[12] = '\x7f';  // right ascension: not a number
  changed[13] = '\xf8';
  const TemporaryFile nan(changed);
  CHECK(has(reason(nan.path), "star 0 makes no sense"));
}

TEST_CASE("stars: magnitude 0 gives 2.54e-6 lux, five magnitudes a hundredth") {
  CHECK(star_illuminance_lux(0.0) == 2.54e-6);
  CHECK(star_illuminance_lux(5.0) == doctest::Approx(2.54e-8));
}

TEST_CASE("colours: a body of 6504 K is near white, colour indices give the temperatures of known stars") {
  const dvec3 white = rec709_from_planck(6504.0);  // Planck's own locus: a little pinker than D65
  CHECK(white.x == doctest::Approx(1.0).epsilon(0.03));
  CHECK(white.y == doctest::Approx(1.0).epsilon(0.03));
  CHECK(white.z == doctest::Approx(1.0).epsilon(0.03));
  CHECK(kelvin_from_b_minus_v(0.65) == doctest::Approx(5778.0).epsilon(0.01));  // the sun
  CHECK(kelvin_from_b_minus_v(0.0) == doctest::Approx(10125.0).epsilon(0.01));  // the fit's own value at A0
  CHECK(kelvin_from_b_minus_v(1.54) == doctest::Approx(3910.0).epsilon(0.05));  // Aldebaran
}
