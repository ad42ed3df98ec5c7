// No ring, seam or step at the horizon, from 2 m to 40,000 km.
//
// All cameras lie on one line that touches WGS84 at a point P, so each of them has its horizon exactly there, and what
// is behind P is the same for all. Rays leave at small angles above and below the line, in the plane of the vertical at
// P.
//
// Three criteria, on the radiance of sky and ground at each wavelength, y = log(L + 2 % of the camera's brightest):
//   - seam: just above the horizon a ray meets the air that is just below it, and then the sky that P sees level:
//     L(+0) = S(-0) + T(-0) L_P. A table of the sky whose horizon is elsewhere than the ground's, or that smears over
//     it, breaks this; physics cannot.
//   - ring: within one side, along the angle. y is a curve there, and 200 samples are dense enough for it: a difference
//     between two of them that stands out from those on both its sides is a step of the tables.
//   - sweep: the same along the altitude, at angles that keep their place in the limb as the camera recedes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "atmosphere/atmosphere_fixture.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

AtmosphereParams earth() {
  AtmosphereParams p = AtmosphereParams::earth();
  p.spectral = "fast";
  return p;
}

std::vector<double> log_spaced(double from, double to, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(from * std::pow(to / from, static_cast<double>(i) / (count - 1)));
  return out;
}

/// The line of cameras and the sun.
struct Scene {
  glm::dvec3 touch, up, along, sun;  ///< P, the vertical there, the way the cameras look, towards the sun

  Scene(double sun_elevation_deg, double sun_azimuth_deg) {
    const double lat = 0.7, lon = 0.3, azimuth = 0.5;
    touch = ecef_from_geodetic({lat, lon, 0.0});
    up = geodetic_up_ecef(lat, lon);
    const glm::dvec3 east(-std::sin(lon), std::cos(lon), 0.0), north = glm::cross(up, east);
    along = north * std::cos(azimuth) + east * std::sin(azimuth);
    const glm::dvec3 side = glm::cross(along, up);
    const double e = sun_elevation_deg * kDegree, a = sun_azimuth_deg * kDegree;
    sun = up * std::sin(e) + (along * std::cos(a) + side * std::sin(a)) * std::cos(e);
  }

  /// From the camera at an altitude to P, m.
  double distance(double altitude_m) const {
    double near = 0.0, far = 1e9;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (near + far);
      (geodetic_from_ecef(touch - along * middle).height_m < altitude_m ? near : far) = middle;
    }
    return far;
  }

  shared::AtmosphereCase ray(double distance_m, double angle_rad) const {
    const glm::dvec3 dir = along * std::cos(angle_rad) + up * std::sin(angle_rad);
    return view_case(touch - along * distance_m, dir, sun, angle_rad < 0.0, Ellipsoid::wgs84());
  }

  /// The sun's cosine where that ray meets the ground.
  float foot_mu_s(double distance_m, double angle_rad) const {
    const double s = Ellipsoid::wgs84().a_over_b(), a = Ellipsoid::wgs84().a_m;
    const glm::dvec3 from = touch - along * distance_m, dir = along * std::cos(angle_rad) + up * std::sin(angle_rad);
    const glm::dvec3 o(from.x, from.y, from.z * s), d(dir.x, dir.y, dir.z * s);
    const double dd = glm::dot(d, d), od = glm::dot(o, d);
    const double t = (-od - std::sqrt(std::max(od * od - dd * (glm::dot(o, o) - a * a), 0.0))) / dd;
    const glm::dvec3 foot = from + dir * t;
    return static_cast<float>(glm::dot(glm::normalize(glm::dvec3(foot.x, foot.y, foot.z * s * s)), sun));
  }
};

struct Sight {
  glm::dvec3 light{0.0};  ///< of the air and, below the horizon, the ground
  glm::dvec3 air{0.0}, transmittance{1.0};
};

/// What cameras at `altitudes` see at `angles`, one vector per altitude.
std::vector<std::vector<Sight>> look(AtmosphereFixture& gpu, const AtmosphereParams& p, const Scene& scene,
                                     const std::vector<double>& altitudes,
                                     const std::vector<std::vector<double>>& angles) {
  std::vector<shared::AtmosphereCase> cases;
  for (size_t i = 0; i < altitudes.size(); ++i) {
    const double distance = scene.distance(altitudes[i]);
    for (const double angle : angles[i]) {
      cases.push_back(scene.ray(distance, angle));
      cases.back().mu_s = scene.foot_mu_s(distance, angle);  // of the ground; h stays 0
    }
  }
  const auto air = gpu.ask(p, shared::kProbeSkyRadiance, cases);
  const auto ground = gpu.ask(p, shared::kProbeIrradiance, cases);
  std::vector<std::vector<Sight>> out;
  size_t n = 0;
  for (const auto& row : angles) {
    out.emplace_back();
    for (const double angle : row) {
      Sight s{glm::dvec3(air[n].a), glm::dvec3(air[n].a), glm::dvec3(air[n].b)};
      if (angle < 0.0) s.light += s.transmittance * glm::dvec3(ground[n].a + ground[n].b) * (p.ground_albedo / kPi);
      out.back().push_back(s);
      ++n;
    }
  }
  return out;
}

/// The largest jump: a difference between neighbours that is above, or below, the differences on both its sides, by the
/// lesser of the two amounts. 0 for a straight line and for one with a bend.
double worst_step(const std::vector<double>& y) {
  double worst = 0.0;
  for (size_t i = 1; i + 2 < y.size(); ++i) {
    const double step = y[i + 1] - y[i], before = step - (y[i] - y[i - 1]), after = step - (y[i + 2] - y[i + 1]);
    if (before * after > 0.0) worst = std::max(worst, std::min(std::abs(before), std::abs(after)));
  }
  return worst;
}

/// Elevation and azimuth from the way the cameras look, degrees, and what the seam and a step above the horizon may be,
/// relative: what the eye just sees in a sky by day (1 to 2 %), and more in the falling light of dusk.
struct Sun {
  double elevation_deg, azimuth_deg, seam, step;
};
constexpr Sun kSuns[4] = {
    {45.0, 60.0, 0.005, 0.025}, {5.0, 20.0, 0.005, 0.025}, {0.0, 150.0, 0.025, 0.03}, {-3.0, 30.0, 0.03, 0.06}};
constexpr double kStepBelow = 0.01;  ///< there the ground outshines the air, or the path is short

}  // namespace

TEST_CASE("sky and ground meet at the horizon as the sky behind it demands, at 60 altitudes from 2 m to 40,000 km") {
  AtmosphereFixture gpu;
  const std::vector<double> altitudes = log_spaced(2.0, 4e7, 60);
  for (const Sun& sun : kSuns) {
    const Scene scene(sun.elevation_deg, sun.azimuth_deg);
    std::vector<std::vector<double>> angles;
    for (const double altitude : altitudes) {
      const double thin = 1.0 / scene.distance(altitude);  // a metre at the horizon
      angles.push_back({thin, -thin});
    }
    const auto seen = look(gpu, earth(), scene, altitudes, angles);
    const glm::dvec3 behind = look(gpu, earth(), scene, {0.5}, {{1e-6}})[0][0].light;
    double worst = 0.0;
    for (size_t i = 0; i < altitudes.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const double expected = seen[i][1].air[c] + seen[i][1].transmittance[c] * behind[c];
        worst = std::max(worst, std::abs(seen[i][0].light[c] / expected - 1.0));
      }
    MESSAGE("sun at " << sun.elevation_deg << " degrees: seam " << worst);
    CHECK(worst < sun.seam);
  }
}

TEST_CASE("no step in the light within 3 degrees of the horizon, above or below, at 60 altitudes") {
  AtmosphereFixture gpu;
  const std::vector<double> altitudes = log_spaced(2.0, 4e7, 60);
  for (const Sun& sun : kSuns) {
    const Scene scene(sun.elevation_deg, sun.azimuth_deg);
    for (const double side : {1.0, -1.0}) {
      std::vector<double> angles = log_spaced(0.0005 * kDegree, 3.0 * kDegree, 200);
      for (double& a : angles) a *= side;
      const auto seen =
          look(gpu, earth(), scene, altitudes, std::vector<std::vector<double>>(altitudes.size(), angles));
      double worst = 0.0, where = 0.0;
      for (size_t i = 0; i < altitudes.size(); ++i)
        for (int c = 0; c < 3; ++c) {
          std::vector<double> y;
          double brightest = 0.0;
          for (const Sight& s : seen[i]) brightest = std::max(brightest, s.light[c]);
          for (const Sight& s : seen[i]) y.push_back(std::log(s.light[c] + 0.02 * brightest));
          const double w = worst_step(y);
          if (w > worst) where = altitudes[i];
          worst = std::max(worst, w);
        }
      MESSAGE("sun at " << sun.elevation_deg << " degrees, side " << side << ": step " << worst << " at " << where
                        << " m");
      CHECK(worst < (side > 0.0 ? sun.step : kStepBelow));
    }
  }
}

TEST_CASE("the light about the horizon changes without a step as the camera rises from 2 m to 40,000 km") {
  AtmosphereFixture gpu;
  const std::vector<double> altitudes = log_spaced(2.0, 4e7, 237);  // 60 altitudes, and three between each two
  for (const Sun& sun : kSuns) {
    const Scene scene(sun.elevation_deg, sun.azimuth_deg);
    const std::vector<double> places = {0.001, 0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0};
    for (const double side : {1.0, -1.0}) {
      std::vector<std::vector<double>> angles;
      for (const double altitude : altitudes) {
        angles.emplace_back();
        // 3 degrees near the ground, the air's depth from afar.
        const double scale = 3.0 * kDegree / (1.0 + scene.distance(altitude) / 9e5);
        for (const double place : places) angles.back().push_back(side * place * scale);
      }
      const auto seen = look(gpu, earth(), scene, altitudes, angles);
      double worst = 0.0, where = 0.0;
      for (size_t k = 0; k < places.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          std::vector<double> y;
          for (const auto& row : seen) {
            double brightest = 0.0;
            for (const Sight& s : row) brightest = std::max(brightest, s.light[c]);
            y.push_back(std::log(row[k].light[c] + 0.02 * brightest));
          }
          for (size_t i = 0; i + 3 < y.size(); ++i) {
            const double w = worst_step({y[i], y[i + 1], y[i + 2], y[i + 3]});
            if (w > worst) where = altitudes[i + 1];
            worst = std::max(worst, w);
          }
        }
      MESSAGE("sun at " << sun.elevation_deg << " degrees, side " << side << ": step " << worst << " at " << where
                        << " m");
      CHECK(worst < (side > 0.0 ? sun.step : kStepBelow));
    }
  }
}
