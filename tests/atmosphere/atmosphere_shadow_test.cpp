// Paths whose last part lies in a cloud's shadow.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "atmosphere/atmosphere_fixture.h"

using namespace nepho;

namespace {

struct Path {
  double height_m;  ///< of the camera
  glm::dvec3 dir;   ///< x is up
  float distance_m;
  float shadow_m;
};
const Path kPaths[] = {{2.0, {0.0, 1.0, 0.0}, 50.0f, 20.0f},      {2.0, {0.3, 1.0, 0.2}, 5000.0f, 1000.0f},
                       {10.0, {0.02, 1.0, 0.5}, 100e3f, 60e3f},   {3000.0, {-0.1, 1.0, 0.0}, 20e3f, 19e3f},
                       {11000.0, {-0.4, 1.0, -0.3}, 25e3f, 3e3f}, {20000.0, {-1.0, 0.1, 0.0}, 18e3f, 6e3f},
                       {400e3, {-1.0, 0.3, 0.1}, 415e3f, 10e3f}};

AtmosphereParams demo(int orders) { return bruneton_demo(orders); }

struct Lit {
  glm::vec3 light, transmittance;
};
std::vector<Lit> ask(AtmosphereFixture& gpu, int orders, bool shadow, bool cut_off) {
  const Ellipsoid sphere = Ellipsoid::sphere(6360000.0);
  std::vector<shared::AtmosphereCase> cases;
  for (const Path& p : kPaths)
    for (const glm::dvec3& sun : {glm::dvec3(0.7, 0.5, 0.5), glm::dvec3(0.1, -0.9, 0.3)}) {
      cases.push_back(view_case({6360000.0 + p.height_m, 0.0, 0.0}, p.dir, sun, false, sphere));
      cases.back().distance_m = p.distance_m - (cut_off ? p.shadow_m : 0.0f);
      cases.back().shadow_m = shadow ? p.shadow_m : 0.0f;
    }
  std::vector<Lit> out;
  for (const auto& a : gpu.ask(demo(orders), shared::kProbeRadianceToPoint, cases)) out.push_back({a.a, a.b});
  return out;
}

}  // namespace

TEST_CASE("a path whose end is in shadow has the single scattering of its lit part, to 0.2 %, and all of its air") {
  AtmosphereFixture gpu;
  const auto shaded = ask(gpu, 1, true, false), lit_part = ask(gpu, 1, false, true), open = ask(gpu, 1, false, false);
  for (size_t i = 0; i < shaded.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      CAPTURE(i / 2);
      CAPTURE(c);
      CHECK(shaded[i].light[c] == doctest::Approx(lit_part[i].light[c]).epsilon(2e-3));
      CHECK(shaded[i].light[c] < 0.999f * open[i].light[c]);
      CHECK(shaded[i].transmittance[c] == doctest::Approx(open[i].transmittance[c]).epsilon(2e-4));
    }
}

TEST_CASE("shadow takes single scattering only: multiple scattering is that of the whole path, to 0.5 % of the light") {
  AtmosphereFixture gpu;
  const auto shaded = ask(gpu, 4, true, false), open = ask(gpu, 4, false, false);
  const auto shaded_once = ask(gpu, 1, true, false), open_once = ask(gpu, 1, false, false);
  for (size_t i = 0; i < shaded.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      CAPTURE(i / 2);
      const float again = open[i].light[c] - open_once[i].light[c];
      CHECK(again > 0.0f);
      CHECK(std::abs(shaded[i].light[c] - shaded_once[i].light[c] - again) < 5e-3f * open[i].light[c]);
    }
}

TEST_CASE("a path wholly in shadow keeps its multiple scattering alone") {
  AtmosphereFixture gpu;
  auto c = view_case({6360002.0, 0.0, 0.0}, {0.1, 1.0, 0.0}, {0.7, 0.5, 0.5}, false, Ellipsoid::sphere(6360000.0));
  c.distance_m = c.shadow_m = 10e3f;
  auto beyond = c;
  beyond.shadow_m = 50e3f;
  const auto once = gpu.ask(demo(1), shared::kProbeRadianceToPoint, {c, beyond});
  const auto all = gpu.ask(demo(4), shared::kProbeRadianceToPoint, {c, beyond});
  for (const size_t i : {size_t{0}, size_t{1}})
    for (int k = 0; k < 3; ++k) {
      CHECK(once[i].a[k] < 1e-6f * all[i].a[k]);
      CHECK(all[i].a[k] > 0.0f);
    }
}
