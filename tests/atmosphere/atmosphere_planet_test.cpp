// Planets that are not the Earth, so that no constant of the Earth's can hide: light scattered once, against an
// integral in double precision that knows nothing of scaled space, tables or the shaders' geometry. Straight lines in
// true metres, heights above the ellipsoid, the sun's path integrated anew at every point.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "atmosphere/atmosphere_fixture.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;

/// A dusty desert planet: 1 % oblate, thin gas, an absorbing layer at 30 km, aerosol that darkens blue light.
AtmosphereParams dusty(double flattening) {
  AtmosphereParams p;
  p.equatorial_radius_m = 3390000.0;
  p.polar_radius_m = 3390000.0 * (1.0 - flattening);
  p.top_height_m = 80000.0;
  p.rayleigh.scattering_per_m = {3.2e-7, 7.5e-7, 1.83e-6};
  p.rayleigh.scale_height_m = 11000.0;
  p.mie.scattering_per_m = {1.9e-5, 1.7e-5, 1.3e-5};
  p.mie.extinction_per_m = {2.0e-5, 2.0e-5, 2.1e-5};
  p.mie.scale_height_m = 11000.0;
  p.mie.phase_g = 0.65;
  p.ozone.absorption_per_m = {5e-7, 1e-6, 2e-6};
  p.ozone.center_m = 30000.0;
  p.ozone.half_width_m = 10000.0;
  p.solar_irradiance_W_m2_nm *= 0.43;
  p.scattering_orders = 1;
  p.spectral = "fast";
  return p;
}

/// A small one in much air: the top is at an eighth of the radius.
AtmosphereParams small() {
  AtmosphereParams p;
  p.equatorial_radius_m = p.polar_radius_m = 500000.0;
  p.top_height_m = 60000.0;
  p.rayleigh.scattering_per_m = {6.0e-6, 1.2e-5, 2.5e-5};
  p.rayleigh.scale_height_m = 9000.0;
  p.mie.scattering_per_m = {2.0e-5, 2.4e-5, 2.8e-5};
  p.mie.extinction_per_m = {2.2e-5, 2.6e-5, 3.0e-5};
  p.mie.scale_height_m = 3000.0;
  p.mie.phase_g = 0.5;
  p.ozone.absorption_per_m = {4e-6, 1e-6, 5e-7};
  p.ozone.center_m = 20000.0;
  p.ozone.half_width_m = 8000.0;
  p.scattering_orders = 1;
  p.spectral = "fast";
  return p;
}

/// The model that the tables approximate.
class Witness {
 public:
  explicit Witness(const AtmosphereParams& p) : p_(p), a_over_b_(p.equatorial_radius_m / p.polar_radius_m) {}

  /// Above the ellipsoid, m: its level function over the gradient of that; 0.1 m at 100 m height, 50 m at 80 km, on a
  /// planet that is 1 % oblate; exact on a sphere.
  double height(const glm::dvec3& at) const {
    const glm::dvec3 q(at.x, at.y, at.z * a_over_b_);
    const double level = glm::length(q);
    return (level - p_.equatorial_radius_m) * level / glm::length(glm::dvec3(q.x, q.y, q.z * a_over_b_));
  }

  /// Where a line meets the ellipsoid raised by `height_m`: distances, second below first when it does not.
  std::pair<double, double> shell(const glm::dvec3& from, const glm::dvec3& dir, double height_m) const {
    const double a = p_.equatorial_radius_m + height_m, b = p_.polar_radius_m + height_m, s = a / b;
    const glm::dvec3 o(from.x, from.y, from.z * s), d(dir.x, dir.y, dir.z * s);
    const double dd = glm::dot(d, d), od = glm::dot(o, d), det = od * od - dd * (glm::dot(o, o) - a * a);
    if (det < 0.0) return {1.0, 0.0};
    return {(-od - std::sqrt(det)) / dd, (-od + std::sqrt(det)) / dd};
  }

  /// Densities of gas, aerosol and absorber.
  glm::dvec3 densities(double h) const {
    h = std::max(h, 0.0);
    return glm::dvec3(std::exp(-h / p_.rayleigh.scale_height_m), std::exp(-h / p_.mie.scale_height_m),
                      std::max(0.0, 1.0 - std::abs(h - p_.ozone.center_m) / p_.ozone.half_width_m));
  }
  glm::dvec3 extinction(const glm::dvec3& columns) const {
    return columns.x * p_.rayleigh.scattering_per_m + columns.y * p_.mie.extinction_per_m +
           columns.z * p_.ozone.absorption_per_m;
  }

  /// Sunlight's share at a point within the air.
  glm::dvec3 sunlight(const glm::dvec3& at, const glm::dvec3& sun) const {
    const auto ground = shell(at, sun, 0.0);
    if (ground.first <= ground.second && ground.first > 0.0) return glm::dvec3(0.0);
    const double length = shell(at, sun, p_.top_height_m).second;
    constexpr int kSteps = 160;
    glm::dvec3 columns(0.0);
    for (int i = 0; i < kSteps; ++i) {
      // Square steps: short ones near the point, where the air is dense.
      const double s = (i + 0.5) / kSteps;
      columns += densities(height(at + sun * (length * s * s))) * (2.0 * s * length / kSteps);
    }
    return glm::exp(-extinction(columns));
  }

  struct Light {
    glm::dvec3 radiance{0.0}, transmittance{1.0};
  };
  Light look(const glm::dvec3& camera, const glm::dvec3& dir, const glm::dvec3& sun, int steps) const {
    Light out;
    const auto air = shell(camera, dir, p_.top_height_m), ground = shell(camera, dir, 0.0);
    if (air.first > air.second || air.second < 0.0) return out;
    const double start = std::max(air.first, 0.0);
    const double end = ground.first <= ground.second && ground.first > 0.0 ? ground.first : air.second;
    const double cosine = glm::dot(dir, sun), g = p_.mie.phase_g;
    const double gas_phase = 3.0 / (16.0 * kPi) * (1.0 + cosine * cosine);
    // Cornette and Shanks 1992.
    const double dust_phase = 3.0 / (8.0 * kPi) * (1.0 - g * g) * (1.0 + cosine * cosine) /
                              ((2.0 + g * g) * std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
    const double step = (end - start) / steps;
    glm::dvec3 columns(0.0);
    for (int i = 0; i < steps; ++i) {
      const glm::dvec3 at = camera + dir * (start + (i + 0.5) * step);
      const glm::dvec3 d = densities(height(at));
      const glm::dvec3 seen = glm::exp(-extinction(columns + 0.5 * step * d));
      columns += step * d;
      out.radiance += step * seen * sunlight(at, sun) *
                      (d.x * gas_phase * p_.rayleigh.scattering_per_m + d.y * dust_phase * p_.mie.scattering_per_m);
    }
    out.radiance *= p_.solar_irradiance_W_m2_nm;
    out.transmittance = glm::exp(-extinction(columns));
    return out;
  }

 private:
  AtmosphereParams p_;
  double a_over_b_;
};

struct Errors {
  std::vector<double> radiance;      ///< relative to max(truth, 2 % of the brightest), sorted
  double transmittance_worst = 0.0;  ///< absolute
  double median() const { return radiance[radiance.size() / 2]; }
  double percentile95() const { return radiance[radiance.size() * 95 / 100]; }
};

/// Cameras from 2 m to three radii above a place, rays up, level, through the limb and to the ground, by day.
Errors against_witness(AtmosphereFixture& gpu, const AtmosphereParams& p) {
  const Witness witness(p);
  const Ellipsoid planet{p.equatorial_radius_m, p.polar_radius_m};
  std::vector<shared::AtmosphereCase> cases;
  std::vector<Witness::Light> truth;
  double brightest = 0.0;
  for (const double lat_deg : {5.0, 50.0, 85.0}) {
    const double lat = lat_deg * kPi / 180.0, lon = 0.7;
    const glm::dvec3 up = geodetic_up_ecef(lat, lon);
    const glm::dvec3 east(-std::sin(lon), std::cos(lon), 0.0), north = glm::cross(up, east);
    for (const double height : {2.0, 3000.0, 25000.0, 1.5 * p.top_height_m, 3.0 * p.equatorial_radius_m}) {
      const glm::dvec3 camera = ecef_from_geodetic({lat, lon, height}, planet);
      const double r = p.equatorial_radius_m, dip = std::acos(r / (r + height));
      for (const double sun_elevation_deg : {20.0, 65.0}) {
        const double e = sun_elevation_deg * kPi / 180.0;
        const glm::dvec3 sun = up * std::sin(e) + east * std::cos(e);
        std::vector<double> elevations = {1.2, 0.3, 0.02, -dip - 0.02, -dip - 0.1, -1.3};
        for (const double lowest : {0.02, 0.1, 0.4})  // through the limb
          if (height > lowest * p.top_height_m)
            elevations.push_back(-std::acos((r + lowest * p.top_height_m) / (r + height)));
        for (const double elevation : elevations) {
          if (elevation < -1.55) continue;
          // Seen from space the sun stands lower at the far limb: rays to the sun's side, and across.
          const double azimuth = height > p.top_height_m ? 0.4 : 2.0;
          const glm::dvec3 level = east * std::cos(azimuth) + north * std::sin(azimuth);
          const glm::dvec3 dir = glm::normalize(up * std::sin(elevation) + level * std::cos(elevation));
          const auto air = witness.shell(camera, dir, p.top_height_m), ground = witness.shell(camera, dir, 0.0);
          if (air.first > air.second || air.second < 0.0) continue;
          cases.push_back(view_case(camera, dir, sun, ground.first <= ground.second && ground.first > 0.0, planet));
          truth.push_back(witness.look(camera, dir, sun, 800));
          brightest = std::max(brightest, truth.back().radiance[1]);
        }
      }
    }
  }
  const auto found = gpu.ask(p, shared::kProbeSkyRadiance, cases);
  Errors errors;
  for (size_t i = 0; i < cases.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double t = truth[i].radiance[c];
      errors.radiance.push_back(std::abs(static_cast<double>(found[i].a[c]) - t) / std::max(t, 0.02 * brightest));
      errors.transmittance_worst = std::max(errors.transmittance_worst,
                                            std::abs(static_cast<double>(found[i].b[c]) - truth[i].transmittance[c]));
    }
  std::sort(errors.radiance.begin(), errors.radiance.end());
  return errors;
}

}  // namespace

TEST_CASE("the witness has a vertical optical depth of density times scale height") {
  const AtmosphereParams p = small();
  const glm::dvec3 up(0, 0, 1), ground = up * 500000.0;
  const glm::dvec3 t = Witness(p).look(ground, up, up, 4000).transmittance;
  for (int c = 0; c < 3; ++c) {
    const double tail = 1.0 - std::exp(-60000.0 / 9000.0);
    CHECK(-std::log(t[c]) == doctest::Approx(p.rayleigh.scattering_per_m[c] * 9000.0 * tail +
                                             p.mie.extinction_per_m[c] * 3000.0 + p.ozone.absorption_per_m[c] * 8000.0)
                                 .epsilon(1e-4));
  }
}

TEST_CASE("a dusty sphere of 3,390 km: single scattering by day within 0.1 % (median), 0.5 % (95 %), 1 %") {
  AtmosphereFixture gpu;
  const Errors e = against_witness(gpu, dusty(0.0));
  MESSAGE("median " << e.median() << ", 95 % " << e.percentile95() << ", worst " << e.radiance.back()
                    << ", transmittance " << e.transmittance_worst);
  CHECK(e.median() < 0.001);
  CHECK(e.percentile95() < 0.005);
  CHECK(e.radiance.back() < 0.01);
  CHECK(e.transmittance_worst < 7e-4);
}

TEST_CASE("a small planet in much air: single scattering by day within 0.1 % (median), 0.5 % (95 %), 1 %") {
  AtmosphereFixture gpu;
  const Errors e = against_witness(gpu, small());
  MESSAGE("median " << e.median() << ", 95 % " << e.percentile95() << ", worst " << e.radiance.back()
                    << ", transmittance " << e.transmittance_worst);
  CHECK(e.median() < 0.001);
  CHECK(e.percentile95() < 0.005);
  CHECK(e.radiance.back() < 0.01);
  CHECK(e.transmittance_worst < 7e-4);
}

// Scaled space stretches heights and lengths along the axis by up to a/b.
TEST_CASE("a dusty planet 1 % oblate: single scattering by day within 1.5 % of that of true heights (95 %)") {
  AtmosphereFixture gpu;
  const Errors e = against_witness(gpu, dusty(0.01));
  MESSAGE("median " << e.median() << ", 95 % " << e.percentile95() << ", worst " << e.radiance.back()
                    << ", transmittance " << e.transmittance_worst);
  CHECK(e.median() < 0.002);
  CHECK(e.percentile95() < 0.015);
}
