// The luminance and colour of the sky: fifteen wavelengths, and three, against an integral over the visible spectrum in
// steps of 1 nm of light that is scattered once, which knows no tables, and no spectrum but the published ones.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "atmosphere/atmosphere_fixture.h"
#include "atmosphere/luminance.h"
#include "atmosphere/standard_spectra.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi, kRadius_m = 6378137.0, kTop_m = 100e3;

/// The default air over a sphere.
AtmosphereParams sphere(const std::string& spectral) {
  AtmosphereParams p = AtmosphereParams::earth();
  p.polar_radius_m = p.equatorial_radius_m;
  p.scattering_orders = 1;
  p.spectral = spectral;
  return p;
}

double power_between(double nm, double nm_a, double a, double nm_b, double b) {
  return a * std::pow(nm / nm_a, std::log(b / a) / std::log(nm_b / nm_a));
}
/// Of the three values the power through the nearer two.
double aerosol_per_m(const glm::dvec3& v, double nm) {
  return nm < 550.0 ? power_between(nm, 440.0, v[2], 550.0, v[1]) : power_between(nm, 550.0, v[1], 680.0, v[0]);
}

/// Heights of points on a straight line from height h, without the cancellation of |p| - R.
double height_at(double h, double mu, double t) {
  const double r = kRadius_m + h, x = h * (2.0 * kRadius_m + h) + t * (2.0 * r * mu + t);
  return x / (kRadius_m + std::sqrt(kRadius_m * kRadius_m + x));
}
double to_top(double h, double mu) {
  const double r = kRadius_m + h, top = kRadius_m + kTop_m;
  return -r * mu + std::sqrt(r * r * (mu * mu - 1.0) + top * top);
}
glm::dvec3 densities(double h) {
  h = std::max(h, 0.0);
  return {std::exp(-h / 8000.0), std::exp(-h / 1200.0), std::max(0.0, 1.0 - std::abs(h - 25e3) / 15e3)};
}

/// A point of the path: what the air before it and on the way from the sun holds, m, and how much scatters there, m.
struct Node {
  glm::dvec3 columns{0.0};
  double gas_m = 0.0, aerosol_m = 0.0;
};

std::vector<Node> path(double camera_m, double mu, double mu_s, double nu) {
  constexpr int kSteps = 3000, kSunSteps = 800;
  const double r = kRadius_m + camera_m, length = to_top(camera_m, mu);
  constexpr double alpha = 0.00935 / 2.0;
  std::vector<Node> nodes;
  glm::dvec3 behind(0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps, t = length * s * s, step = 2.0 * length * s / kSteps;
    const double h = height_at(camera_m, mu, t);
    const glm::dvec3 d = densities(h);
    const double sun = (r * mu_s + t * nu) / (kRadius_m + h);
    // The part of the sun's disc above the horizon: a segment of a circle.
    const double dip = std::acos(std::min(1.0, kRadius_m / (kRadius_m + h)));
    const double x = std::clamp((std::asin(std::clamp(sun, -1.0, 1.0)) + dip) / alpha, -1.0, 1.0);
    const double visible = 0.5 + (std::asin(x) + x * std::sqrt(1.0 - x * x)) / kPi;
    if (visible > 0.0) {
      Node node;
      node.columns = behind + 0.5 * step * d;
      const double way = to_top(h, sun), low = std::clamp(-(kRadius_m + h) * sun, 0.0, way);
      for (int k = 0; k < kSunSteps; ++k) {
        // From the lowest point, if there is one, both ways in square steps.
        const double u = (k + 0.5) / kSunSteps, up = way - low;
        node.columns += densities(height_at(h, sun, low + up * u * u)) * (2.0 * up * u / kSunSteps);
        if (low > 0.0) node.columns += densities(height_at(h, sun, low - low * u * u)) * (2.0 * low * u / kSunSteps);
      }
      node.gas_m = visible * step * d.x;
      node.aerosol_m = visible * step * d.y;
      nodes.push_back(node);
    }
    behind += step * d;
  }
  return nodes;
}

glm::dvec3 dense_luminance(const AtmosphereParams& p, double camera_m, double mu, double mu_s, double nu) {
  const double g = p.mie.phase_g;
  const double gas_phase = 3.0 / (16.0 * kPi) * (1.0 + nu * nu);
  const double aerosol_phase =
      3.0 / (8.0 * kPi) * (1.0 - g * g) * (1.0 + nu * nu) / ((2.0 + g * g) * std::pow(1.0 + g * g - 2.0 * g * nu, 1.5));
  const std::vector<Node> nodes = path(camera_m, mu, mu_s, nu);
  glm::dvec3 sum(0.0);
  for (int i = 0; i < 470; ++i) {
    const double nm = 360.5 + i, gas = gas_per_m(nm), ozone = ozone_per_m(nm);
    const double extinction = aerosol_per_m(p.mie.extinction_per_m, nm);
    const double scattering = aerosol_per_m(p.mie.scattering_per_m, nm);
    double light = 0.0;
    for (const Node& n : nodes)
      light += std::exp(-gas * n.columns.x - extinction * n.columns.y - ozone * n.columns.z) *
               (gas * gas_phase * n.gas_m + scattering * aerosol_phase * n.aerosol_m);
    sum += rgb_response(nm) * standard_solar_irradiance(nm) * light;
  }
  return sum;
}

double luminance(const glm::dvec3& c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); }

/// CIE 1976 u', v' of linear Rec. 709.
glm::dvec2 uv_of(const glm::dvec3& c) {
  const double x = 0.4124 * c.r + 0.3576 * c.g + 0.1805 * c.b, y = luminance(c),
               z = 0.0193 * c.r + 0.1192 * c.g + 0.9505 * c.b;
  return glm::dvec2(4.0 * x, 9.0 * y) / (x + 15.0 * y + 3.0 * z);
}

}  // namespace

// Three wavelengths stand for a spectrum of one shape (luminance.h), which light through much ozone does not have.
TEST_CASE("fifteen wavelengths give the sky's luminance by day to 1 % and colour to 0.001 u'v', at -3 degrees to 3 %") {
  AtmosphereFixture gpu;
  struct View {
    double sun_deg, elevation_deg, azimuth_deg;
  };
  std::vector<View> views;
  for (const double sun : {45.0, 5.0, 0.0, -3.0})
    for (const glm::dvec2& dir : {glm::dvec2(90.0, 0.0), glm::dvec2(2.0, 10.0), glm::dvec2(2.0, 90.0)})
      views.push_back({sun, dir.x, dir.y});
  const double camera_m = 2.0;
  std::vector<shared::AtmosphereCase> cases;
  std::vector<glm::dvec3> truth;
  for (const View& v : views) {
    const double e = v.elevation_deg * kPi / 180.0, a = v.azimuth_deg * kPi / 180.0, s = v.sun_deg * kPi / 180.0;
    const glm::dvec3 dir(std::sin(e), std::cos(e) * std::cos(a), std::cos(e) * std::sin(a));
    const glm::dvec3 sun(std::sin(s), std::cos(s), 0.0);
    cases.push_back(view_case({kRadius_m + camera_m, 0.0, 0.0}, dir, sun, false, Ellipsoid::sphere(kRadius_m)));
    truth.push_back(dense_luminance(sphere("full"), camera_m, dir.x, sun.x, glm::dot(dir, sun)));
  }
  for (const bool full : {true, false}) {
    const auto found = gpu.ask(sphere(full ? "full" : "fast"), shared::kProbeLuminance, cases);
    for (size_t i = 0; i < views.size(); ++i) {
      const View& v = views[i];
      const glm::dvec3 f(found[i].a);
      const double error = luminance(f) / luminance(truth[i]) - 1.0, colour = glm::length(uv_of(f) - uv_of(truth[i]));
      MESSAGE((full ? "full" : "fast") << ", sun " << v.sun_deg << ", towards " << v.elevation_deg << ", "
                                       << v.azimuth_deg << ": " << luminance(truth[i]) << " cd/m2, error "
                                       << 100.0 * error << " %, colour " << colour);
      if (full) {
        CHECK(std::abs(error) < (v.sun_deg >= 0.0 ? 0.01 : 0.03));
        CHECK(colour < (v.sun_deg >= 0.0 ? 0.001 : 0.0025));
      } else {
        CHECK(std::abs(error) < (v.sun_deg >= 45.0 ? 0.06 : v.sun_deg >= 5.0 ? 0.35 : 1.5));
        CHECK(colour < (v.sun_deg >= 5.0 ? 0.04 : 0.09));
      }
    }
  }
}

TEST_CASE("at noon in summer sun and sky give a horizontal surface 95,000 to 115,000 lux, the sky 8 to 20 % of it") {
  AtmosphereFixture gpu;
  const AtmosphereParams air = AtmosphereParams::earth();
  REQUIRE(air.spectral == "full");
  shared::AtmosphereCase c =
      view_case({kRadius_m + 2.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.887, 0.462, 0.0}, false, Ellipsoid::wgs84());
  c.h = 2.0f;
  c.mu_s = 0.887f;  // 62.5 degrees, the highest at 51 degrees north
  const glm::dvec3 share(gpu.ask(air, shared::kProbeSunTransmittance, {c})[0].a);
  const glm::dvec3 sky(gpu.ask(air, shared::kProbeIrradiance, {c})[0].b);  // in lux with the full spectrum
  const double sun_lux = 0.887 * luminance(glm::dvec3(sun_illuminance_at_1au(air)) * share), sky_lux = luminance(sky);
  MESSAGE("sun " << sun_lux << " lux, sky " << sky_lux << " lux");
  CHECK(sun_lux + sky_lux > 95e3);
  CHECK(sun_lux + sky_lux < 115e3);
  CHECK(sky_lux > 0.08 * (sun_lux + sky_lux));
  CHECK(sky_lux < 0.20 * (sun_lux + sky_lux));
}
