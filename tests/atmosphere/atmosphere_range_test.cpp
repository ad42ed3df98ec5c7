// The lookups over the whole range of cameras: 2 m to 40,000 km above WGS84, any direction, any sun.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "atmosphere/atmosphere_fixture.h"
#include "atmosphere/luminance.h"
#include "base/files.h"

using namespace nepho;

namespace {

AtmosphereParams earth() {
  AtmosphereParams p = AtmosphereParams::earth();
  p.scattering_orders = 2;  // quicker to build; nothing here depends on more
  return p;
}

struct Random {
  std::mt19937 engine{11};
  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  glm::dvec3 direction() {
    const double z = 2.0 * unit() - 1.0, phi = 2.0 * 3.14159265358979 * unit(), s = std::sqrt(1.0 - z * z);
    return glm::dvec3(s * std::cos(phi), s * std::sin(phi), z);
  }
};

/// A point at a scaled height above the ellipsoid, near enough to a height.
glm::dvec3 point_above(const glm::dvec3& where, double height_m, const Ellipsoid& e = Ellipsoid::wgs84()) {
  const glm::dvec3 q = glm::normalize(where) * (e.a_m + height_m);
  return glm::dvec3(q.x, q.y, q.z / e.a_over_b());
}

bool hits_ground(const shared::AtmosphereCase& c) {
  glm::vec2 t;
  return intersect_shell(c.planet, c.dir, 0.0f, t) && t.x > 0.0f;
}

bool sane_light(const glm::vec3& v) {
  for (int c = 0; c < 3; ++c)
    if (!std::isfinite(v[c]) || v[c] < 0.0f) return false;
  return true;
}
/// A colour beyond Rec. 709 has a negative component; frames bring it back (common/gamut.h). Its luminance has a sign.
bool sane_colour(const glm::vec3& v) {
  const float y = 0.2126f * v.x + 0.7152f * v.y + 0.0722f * v.z;
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && y >= 0.0f;
}
bool sane_share(const glm::vec3& v) { return sane_light(v) && v.x <= 1.0f && v.y <= 1.0f && v.z <= 1.0f; }

}  // namespace

TEST_CASE("no ray from 2 m to 40,000 km gives a NaN, an infinity, a negative light or a transmittance above 1") {
  AtmosphereFixture gpu;
  Random random;
  std::vector<shared::AtmosphereCase> cases;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 place = random.direction();
    const double height = std::exp(std::log(2.0) + random.unit() * std::log(2e7));
    const glm::dvec3 camera = point_above(place, i % 10 == 0 ? 0.5 - i % 3 : height);
    glm::dvec3 sun = random.direction();
    if (i % 17 == 3) sun = glm::normalize(place);
    if (i % 17 == 4) sun = -glm::normalize(place);
    for (int k = 0; k < 10; ++k) {  // of one camera and sun: they share a sky view
      glm::dvec3 dir = random.direction();
      if (k % 3 == 1)  // towards the limb or the disc
        dir = glm::normalize(point_above(random.direction(), 3e4 * random.unit()) - camera);
      if (k == 6) dir = glm::normalize(place);
      if (k == 8) dir = -glm::normalize(place);
      if (k == 9) dir = sun;
      shared::AtmosphereCase c = view_case(camera, dir, sun, false, Ellipsoid::wgs84());
      c.hits_ground = hits_ground(c) ? 1u : 0u;
      c.distance_m = static_cast<float>(std::exp(random.unit() * std::log(1e8)));
      c.shadow_m = k % 4 == 0 ? 0.3f * c.distance_m : 0.0f;
      c.h = static_cast<float>(height);
      c.mu_s = static_cast<float>(2.0 * random.unit() - 1.0);
      cases.push_back(c);
    }
  }
  for (const char* spectral : {"fast", "full"}) {
    AtmosphereParams air = earth();
    air.spectral = spectral;
    const auto sane = air.spectral == "full" ? sane_colour : sane_light;
    const auto sky = gpu.ask(air, shared::kProbeSkyRadiance, cases);
    const auto point = gpu.ask(air, shared::kProbeRadianceToPoint, cases);
    const auto luminance = gpu.ask(air, shared::kProbeLuminance, cases);
    const auto light = gpu.ask(air, shared::kProbeSunTransmittance, cases);
    int bad = 0;
    for (size_t i = 0; i < cases.size(); ++i)
      if (!sane(sky[i].a) || !sane_share(sky[i].b) || !sane(point[i].a) || !sane_share(point[i].b) ||
          !sane(luminance[i].a) || !sane(luminance[i].b) || !sane_share(light[i].a) || !sane(light[i].b))
        ++bad;
    CAPTURE(spectral);
    CHECK(bad == 0);
  }
}

TEST_CASE("a ray from space that misses the air is black and clear") {
  AtmosphereFixture gpu;
  const glm::dvec3 camera = point_above(glm::dvec3(1, 0, 0), 400000.0);
  const auto answers = gpu.ask(earth(), shared::kProbeSkyRadiance,
                               {view_case(camera, {0, 0, 1}, {1, 0, 0}, false, Ellipsoid::wgs84()),
                                view_case(camera, {1, 0, 0}, {0, 1, 0}, false, Ellipsoid::wgs84())});
  for (const auto& a : answers) {
    CHECK(a.a == glm::vec3(0.0f));
    CHECK(a.b == glm::vec3(1.0f));
  }
}

TEST_CASE("in-scattered light of short paths grows with their length, to 0.2 %") {
  AtmosphereFixture gpu;
  std::vector<shared::AtmosphereCase> cases;
  const glm::dvec3 camera = point_above(glm::dvec3(0.6, 0.3, 0.5), 2.0);
  for (const float metres : {1.0f, 2.0f, 20.0f}) {
    cases.push_back(view_case(camera, {-0.5, 0.86, 0.0}, {0.8, 0.5, 0.3}, false, Ellipsoid::wgs84()));
    cases.back().distance_m = metres;
  }
  const auto answers = gpu.ask(earth(), shared::kProbeRadianceToPoint, cases);
  for (int c = 0; c < 3; ++c) {
    CHECK(answers[1].a[c] / answers[0].a[c] == doctest::Approx(2.0).epsilon(2e-3));
    CHECK(answers[2].a[c] / answers[0].a[c] == doctest::Approx(20.0).epsilon(2e-3));
  }
}

TEST_CASE("the sky is the same by table below the top of the air and by integral above it, to 1 % of its brightest") {
  AtmosphereFixture gpu;
  std::vector<shared::AtmosphereCase> cases;
  const glm::dvec3 up(1, 0, 0);
  for (int i = 0; i < 40; ++i) {
    const double mu = -0.003 * (i + 1);  // down to the horizon of the top at -0.175
    const glm::dvec3 dir(mu, std::sqrt(1.0 - mu * mu), 0.0);
    for (const double height : {earth().top_height_m - 10.0, earth().top_height_m + 10.0})
      cases.push_back(view_case(point_above(up, height), dir, {0.5, 0.8, 0.3}, false, Ellipsoid::wgs84()));
  }
  const auto answers = gpu.ask(earth(), shared::kProbeSkyRadiance, cases);
  glm::vec3 brightest(0.0f);
  for (const auto& a : answers) brightest = max(brightest, a.a);
  float worst = 0.0f;
  for (size_t i = 0; i < answers.size(); i += 2)
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(answers[i].a[c] - answers[i + 1].a[c]) / brightest[c]);
  CHECK(worst < 0.01f);
}

TEST_CASE("tables loaded from the cache answer as those that were saved") {
  AtmosphereFixture gpu;
  const AtmosphereTables& first = gpu.tables(earth());
  REQUIRE_FALSE(cache_dir().empty());
  const auto again = std::make_shared<const AtmosphereTables>(gpu.device, earth());
  CHECK(again->came_from_cache());
  AtmosphereProbe again_probe(gpu.device, again);
  auto c =
      view_case(point_above(glm::dvec3(0, 1, 0), 1000.0), {0.3, 0.8, 0.2}, {0.1, 0.5, 0.3}, false, Ellipsoid::wgs84());
  for (const uint32_t kind : {shared::kProbeSkyRadiance, shared::kProbeSunTransmittance}) {
    const auto a = gpu.ask(earth(), kind, {c})[0], b = again_probe.ask(kind, {&c, 1})[0];
    CHECK(a.a == b.a);
    CHECK(a.b == b.b);
    CHECK(a.b.x > 0.0f);
  }
}

TEST_CASE("at noon the sky is thousands of cd/m2 and blue, the sun lights the ground with about 100,000 lux") {
  AtmosphereFixture gpu;
  const glm::dvec3 camera = point_above(glm::dvec3(1, 0, 0), 2.0);
  auto sky = view_case(camera, {0.8, 0.0, 0.6}, {0.866, 0.5, 0.0}, false, Ellipsoid::wgs84());
  sky.distance_m = 1000.0f;
  sky.h = 2.0f;
  sky.mu_s = 0.866f;
  const glm::vec3 l = gpu.ask(earth(), shared::kProbeLuminance, {sky})[0].a;
  CHECK(glm::dot(l, glm::vec3(0.2126f, 0.7152f, 0.0722f)) > 1000.0f);
  CHECK(glm::dot(l, glm::vec3(0.2126f, 0.7152f, 0.0722f)) < 10000.0f);
  CHECK(l.b > 2.0f * l.r);
  const glm::vec3 t = gpu.ask(earth(), shared::kProbeSunTransmittance, {sky})[0].a;
  const glm::vec3 lux = sun_illuminance_at_1au(earth()) * t * 0.866f;
  CHECK(glm::dot(lux, glm::vec3(0.2126f, 0.7152f, 0.0722f)) > 85000.0f);
  CHECK(glm::dot(lux, glm::vec3(0.2126f, 0.7152f, 0.0722f)) < 110000.0f);
}

TEST_CASE("the default air has all its orders and wavelengths, and its noon sky is brighter than its ground is dark") {
  AtmosphereFixture gpu;
  const AtmosphereParams air = AtmosphereParams::earth();
  REQUIRE(air.spectral == "full");
  const glm::dvec3 camera = point_above(glm::dvec3(1, 0, 0), 100.0), sun(0.8, 0.6, 0.0);
  const auto up = view_case(camera, {1.0, 0.2, 0.1}, sun, false, Ellipsoid::wgs84());
  const auto down = view_case(camera, {-1.0, 0.2, 0.1}, sun, true, Ellipsoid::wgs84());
  const auto answers = gpu.ask(air, shared::kProbeLuminance, {up, down});
  const auto luminance = [](const glm::vec3& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; };
  CHECK(luminance(answers[0].a) > 1000.0f);
  CHECK(luminance(answers[0].a) < 20000.0f);
  CHECK(luminance(answers[1].a) < 0.1f * luminance(answers[0].a));  // 100 m of air
}
