// Pure functions of shaders/atmosphere/atmosphere_shared.h against double precision and closed forms.
#include "atmosphere/atmosphere_shared.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "atmosphere/atmosphere_uniform.h"
#include "atmosphere/oracle_table.h"
#include "base/error.h"
#include "common/phase.h"

using namespace nepho;
using namespace nepho::shared;

namespace {

const AtmosphereUniform& demo() {
  static const AtmosphereUniform air = make_atmosphere_uniform(AtmosphereParams::bruneton_demo());
  return air;
}

/// Only gas, with scattering k per metre at the ground.
AtmosphereUniform pure_gas(float k, float scale_height_m) {
  AtmosphereUniform air = demo();
  air.rayleigh_scattering_per_m = glm::vec3(k);
  air.rayleigh_scale_height_m = scale_height_m;
  air.mie_extinction_per_m = glm::vec3(0.0f);
  air.ozone_absorption_per_m = glm::vec3(0.0f);
  return air;
}

struct RandomRay {
  float h, mu;
};
std::vector<RandomRay> random_rays(int count) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<RandomRay> rays;
  for (int i = 0; i < count; ++i)
    rays.push_back({std::exp(std::log(0.1f) + unit(engine) * std::log(6e5f)), 2.0f * unit(engine) - 1.0f});
  return rays;
}

}  // namespace

TEST_CASE("rho and height are each other's inverse to 1 mm or 1e-6 from 0.1 m to the top") {
  for (const RandomRay& ray : random_rays(2000)) {
    const float back = height_from_rho2(demo(), rho2_from_height(demo(), ray.h));
    CHECK(std::abs(back - ray.h) <= std::max(1e-3f, 1e-6f * ray.h));
  }
}

TEST_CASE("distances to the top and the ground agree with double precision") {
  const AtmosphereUniform& air = demo();
  const double R = air.radius_m, top = R + air.top_m;
  for (const RandomRay& ray : random_rays(2000)) {
    const double r = R + static_cast<double>(ray.h), m = static_cast<double>(ray.mu);
    const double to_top = -r * m + std::sqrt(r * r * (m * m - 1.0) + top * top);
    CHECK(std::abs(distance_to_top(air, ray.h, ray.mu) - to_top) <= 0.1 + 1e-5 * to_top);
    const double ground = r * r * (m * m - 1.0) + R * R;
    if (m < 0.0 && ground > 1e8) {  // 10 km from the point of tangency and more
      const double to_ground = -r * m - std::sqrt(ground);
      CHECK(std::abs(distance_to_ground(air, ray.h, ray.mu) - to_ground) <= 1e-3 + 1e-4 * to_ground);
    }
  }
}

TEST_CASE("two metres above the ground, the horizon is 5044 m away and 0.0454 degrees low") {
  const float mu = horizon_mu(demo(), 2.0f);
  CHECK(std::asin(-mu) * 180.0f / kPi == doctest::Approx(0.04544).epsilon(1e-3));
  CHECK(distance_to_ground(demo(), 2.0f, mu * 1.0001f) == doctest::Approx(5044.0).epsilon(0.03));
  CHECK(hits_ground_from(demo(), 2.0f, mu * 1.001f));
  CHECK_FALSE(hits_ground_from(demo(), 2.0f, mu * 0.999f));
}

TEST_CASE("height along a ray agrees with double precision to 2 cm within 300 km") {
  const double R = demo().radius_m;
  for (const RandomRay& ray : random_rays(500)) {
    const double r = R + static_cast<double>(ray.h), t = 3e5 * std::abs(static_cast<double>(ray.mu));
    const double h = std::sqrt(r * r + t * t + 2.0 * r * t * static_cast<double>(ray.mu)) - R;
    if (h < 0.0 || h > 60000.0) continue;
    CHECK(std::abs(height_along(demo(), ray.h, ray.mu, static_cast<float>(t)) - h) < 0.02);
  }
}

TEST_CASE("table coordinates: every texel centre maps to its parameter and back") {
  const AtmosphereUniform& air = demo();
  for (int i = 0; i < kAirR; ++i) {
    const float h = height_from_unit(air, unit_from_texel(i, kAirR));
    CHECK(texel_coord(unit_from_height(air, h), kAirR) * kAirR == doctest::Approx(i + 0.5).epsilon(1e-4));
    for (int j = 0; j < kSkyMu; ++j) {
      const float mu = sky_mu_from_unit(air, h, unit_from_texel(j, kSkyMu));
      CHECK(mu >= horizon_mu(air, h) - 1e-6f);
      CHECK(texel_coord(unit_from_sky_mu(air, h, mu), kSkyMu) * kSkyMu == doctest::Approx(j + 0.5).epsilon(3e-3));
    }
  }
  for (int i = 0; i < kAirMuS; ++i) {
    const float mu_s = mu_s_from_unit(air, unit_from_texel(i, kAirMuS));
    CHECK(texel_coord(unit_from_mu_s(air, mu_s), kAirMuS) * kAirMuS == doctest::Approx(i + 0.5).epsilon(1e-4));
  }
  for (int i = 0; i < kAirNu; ++i) {
    const float unit = unit_from_texel(i, kAirNu);
    CHECK(unit_from_nu(nu_from_unit(unit)) == doctest::Approx(unit).epsilon(1e-4));
  }
}

TEST_CASE("table coordinates reach the ends: zenith, horizon, overhead sun, lowest sun") {
  const AtmosphereUniform& air = demo();
  CHECK(unit_from_height(air, 0.0f) == 0.0f);
  CHECK(unit_from_height(air, air.top_m) == doctest::Approx(1.0).epsilon(1e-6));
  for (const float h : {0.0f, 2.0f, 1000.0f, 59000.0f}) {
    CHECK(unit_from_sky_mu(air, h, 1.0f) == doctest::Approx(0.0).epsilon(1e-4));
    CHECK(unit_from_sky_mu(air, h, horizon_mu(air, h)) == doctest::Approx(1.0).epsilon(1e-4));
  }
  CHECK(unit_from_mu_s(air, 1.0f) == doctest::Approx(1.0).epsilon(1e-4));
  CHECK(unit_from_mu_s(air, -0.2079117f) == doctest::Approx(0.0).epsilon(1e-4));
  CHECK(unit_from_mu_s(air, -1.0f) == 0.0f);
}

TEST_CASE("optical depth straight up is the scale height times what lies below the top") {
  const AtmosphereUniform air = pure_gas(1e-5f, 8000.0f);
  for (const float h : {0.0f, 500.0f, 9000.0f, 30000.0f}) {
    const double exact = 1e-5 * 8000.0 * (std::exp(-h / 8000.0) - std::exp(-60000.0 / 8000.0));
    CHECK(optical_depth_to_top(air, h, 1.0f).x == doctest::Approx(exact).epsilon(1e-4));
  }
}

TEST_CASE("optical depth of ozone straight up is its half width times its absorption") {
  AtmosphereUniform air = pure_gas(0.0f, 8000.0f);
  air.ozone_absorption_per_m = glm::vec3(2e-6f);
  CHECK(optical_depth_to_top(air, 0.0f, 1.0f).x == doctest::Approx(2e-6 * 15000.0).epsilon(1e-3));
}

TEST_CASE("optical depth along the horizontal follows Chapman's function") {
  // Ch(x, 90 deg) = sqrt(pi x / 2) (1 + 3 / (8 x)), x = (R + h) / H; the air above 60 km is cut off: 1e-4 of it.
  const AtmosphereUniform air = pure_gas(1e-5f, 4000.0f);
  for (const float h : {0.0f, 2.0f, 5000.0f}) {
    const double x = (6360000.0 + h) / 4000.0;
    const double chapman = std::sqrt(3.14159265358979 * x / 2.0) * (1.0 + 3.0 / (8.0 * x));
    CHECK(optical_depth_to_top(air, h, 0.0f).x ==
          doctest::Approx(1e-5 * 4000.0 * std::exp(-h / 4000.0) * chapman).epsilon(5e-4));
  }
}

TEST_CASE("transmittance by quadrature agrees with the exact table to 2e-4") {
  const OracleTable table("transmittance.csv");
  ErrorStatistics error("transmittance by quadrature, absolute");
  for (size_t i = 0; i < table.size(); ++i)
    error.add_absolute(exp(-optical_depth_to_top(demo(), static_cast<float>(table.number(i, "r_m") - 6360000.0),
                                                 static_cast<float>(table.number(i, "mu")))),
                       table.rgb(i, "T_exact"));
  error.check(3e-6, 1e-4, 2e-4);  // worst at the horizon: float geometry and the kinks of ozone
}

TEST_CASE("phase functions agree with the table") {
  const OracleTable table("phase_functions.csv");
  for (size_t i = 0; i < table.size(); ++i) {
    const auto nu = static_cast<float>(table.number(i, "nu"));
    CHECK(phase_rayleigh(nu) == doctest::Approx(table.number(i, "rayleigh_per_sr")).epsilon(1e-5));
    CHECK(phase_cornette_shanks(nu, 0.8f) == doctest::Approx(table.number(i, "mie_g0.8_per_sr")).epsilon(1e-4));
  }
}

TEST_CASE("the sun is half visible on the horizon, whole above it and gone below, from every height") {
  const AtmosphereUniform& air = demo();
  for (const float h : {0.0f, 2.0f, 400.0f, 10000.0f, 59000.0f, 400000.0f, 36e6f}) {
    const float horizon = std::acos(horizon_mu(air, h)), alpha = air.sun_angular_radius_rad;
    CHECK(sun_visibility(air, h, std::cos(horizon)) == doctest::Approx(0.5).epsilon(0.01));
    CHECK(sun_visibility(air, h, std::cos(horizon - 1.05f * alpha)) == 1.0f);
    CHECK(sun_visibility(air, h, std::cos(horizon + 1.05f * alpha)) == 0.0f);
  }
}

TEST_CASE("nodes of a path run forward, stay inside it, and their weights add up to its length") {
  for (const RandomRay& ray : random_rays(300)) {
    const bool ground = hits_ground_from(demo(), ray.h, ray.mu);
    const float length = ground ? distance_to_ground(demo(), ray.h, ray.mu) : distance_to_top(demo(), ray.h, ray.mu);
    float last = 0.0f;
    double sum = 0.0;
    for (int part = 0; part < 2; ++part) {
      const PathPart p = path_part(demo(), ray.h, ray.mu, length, part);
      if (p.length_m <= 0.0f) continue;
      for (int k = 0; k < 8; ++k) {
        const glm::vec2 node = path_node(p, kGauss8X[k], kGauss8W[k]);
        CHECK(node.x >= last);
        CHECK(node.x <= length);
        last = node.x;
        sum += static_cast<double>(node.y);
      }
    }
    CHECK(sum == doctest::Approx(static_cast<double>(length)).epsilon(1e-5));
  }
}

TEST_CASE("directions of incident light: 4 pi in all, pi by cosine above, and gas scatters all of it") {
  for (const float h : {0.0f, 2.0f, 10000.0f, 60000.0f}) {
    double all = 0.0, cosine = 0.0, scattered = 0.0;
    const glm::vec3 out = local_direction(0.3f, 1.0f);
    for (int i = 0; i < kIncidentMu; ++i) {
      const glm::vec2 mu = incident_mu(demo(), h, i);
      for (int j = 0; j < kIncidentPhi; ++j)
        for (const float side : {1.0f, -1.0f}) {
          const double w = static_cast<double>(mu.y) * 3.14159265358979 / kIncidentPhi;
          all += w;
          if (mu.x > 0.0f) cosine += w * static_cast<double>(mu.x);
          scattered += w * static_cast<double>(phase_rayleigh(dot(out, local_direction(mu.x, side * incident_phi(j)))));
        }
    }
    CHECK(all == doctest::Approx(4.0 * 3.14159265358979).epsilon(1e-5));
    CHECK(cosine == doctest::Approx(3.14159265358979).epsilon(1e-5));
    CHECK(scattered == doctest::Approx(1.0).epsilon(1e-4));
  }
}

TEST_CASE("parameters that make no sense are refused by name") {
  const auto refused = [](auto&& change) {
    AtmosphereParams p;
    change(p);
    try {
      make_atmosphere_uniform(p);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  CHECK(refused([](AtmosphereParams&) {}) == "accepted");
  CHECK(refused([](AtmosphereParams& p) {
          p.rayleigh.scale_height_m = 0.0;
        }).starts_with("atmosphere.rayleigh.scale_height_m"));
  CHECK(refused([](AtmosphereParams& p) {
          p.mie.extinction_per_m.y = NAN;
        }).starts_with("atmosphere.mie.extinction_per_m"));
  CHECK(refused([](AtmosphereParams& p) {
          p.mie.scattering_per_m.x = 1.0;
        }).starts_with("atmosphere.mie.scattering_per_m"));
  CHECK(
      refused([](AtmosphereParams& p) { p.top_height_m = 5000.0; }).starts_with("atmosphere.rayleigh.scale_height_m"));
  CHECK(refused([](AtmosphereParams& p) { p.scattering_orders = 0; }).starts_with("atmosphere.scattering_orders"));
}
