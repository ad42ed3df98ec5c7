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
  static const AtmosphereUniform air = make_atmosphere_constants(AtmosphereParams::bruneton_demo()).data.air;
  return air;
}

/// Its three wavelengths.
const SpectralGroup& demo_spectrum() {
  static const SpectralGroup group = [] {
    AtmosphereParams p = AtmosphereParams::bruneton_demo();
    p.spectral = "fast";
    return make_atmosphere_constants(p).data.spectrum[0];
  }();
  return group;
}

AtmosphereUniform with_scale_height(float scale_height_m) {
  AtmosphereUniform air = demo();
  air.rayleigh_scale_height_m = scale_height_m;
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
    for (int j = 0; j < kColumnMu; ++j) {
      const float mu = sky_mu_from_unit(air, h, unit_from_texel(j, kColumnMu));
      CHECK(mu >= horizon_mu(air, h) - 1e-6f);
      CHECK(texel_coord(unit_from_sky_mu(air, h, mu), kColumnMu) * kColumnMu == doctest::Approx(j + 0.5).epsilon(3e-3));
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
  CHECK(unit_from_mu_s(air, air.min_mu_s) == doctest::Approx(0.0).epsilon(1e-4));
  CHECK(unit_from_mu_s(air, -1.0f) == 0.0f);
}

TEST_CASE("the column of gas straight up is the scale height times what lies below the top") {
  const AtmosphereUniform air = with_scale_height(8000.0f);
  for (const float h : {0.0f, 500.0f, 9000.0f, 30000.0f}) {
    const double exact = 8000.0 * (std::exp(-h / 8000.0) - std::exp(-60000.0 / 8000.0));
    CHECK(columns_to_top(air, h, 1.0f).x == doctest::Approx(exact).epsilon(1e-4));
  }
}

TEST_CASE("the column of ozone straight up is its half width") {
  CHECK(columns_to_top(demo(), 0.0f, 1.0f).z == doctest::Approx(15000.0).epsilon(1e-3));
}

TEST_CASE("the column of gas along the horizontal follows Chapman's function") {
  // Ch(x, 90 deg) = sqrt(pi x / 2) (1 + 3 / (8 x)), x = (R + h) / H; the air above 60 km is cut off: 1e-4 of it.
  const AtmosphereUniform air = with_scale_height(4000.0f);
  for (const float h : {0.0f, 2.0f, 5000.0f}) {
    const double x = (6360000.0 + h) / 4000.0;
    const double chapman = std::sqrt(3.14159265358979 * x / 2.0) * (1.0 + 3.0 / (8.0 * x));
    CHECK(columns_to_top(air, h, 0.0f).x == doctest::Approx(4000.0 * std::exp(-h / 4000.0) * chapman).epsilon(5e-4));
  }
}

TEST_CASE("transmittance by quadrature agrees with the exact table to 2e-4") {
  const OracleTable table("transmittance.csv");
  ErrorStatistics error("transmittance by quadrature, absolute");
  for (size_t i = 0; i < table.size(); ++i) {
    const glm::vec3 columns = columns_to_top(demo(), static_cast<float>(table.number(i, "r_m") - 6360000.0),
                                             static_cast<float>(table.number(i, "mu")));
    error.add_absolute(exp(-optical_depth(demo_spectrum(), columns)), table.rgb(i, "T_exact"));
  }
  error.check(3e-6, 1e-4, 2e-4);  // worst at the horizon: float geometry and the corners of ozone
}

TEST_CASE("phase functions agree with the table") {
  const OracleTable table("phase_functions.csv");
  for (size_t i = 0; i < table.size(); ++i) {
    const auto nu = static_cast<float>(table.number(i, "nu"));
    CHECK(phase_rayleigh(nu) == doctest::Approx(table.number(i, "rayleigh_per_sr")).epsilon(1e-5));
    CHECK(phase_cornette_shanks(nu, 0.8f) == doctest::Approx(table.number(i, "mie_g0.8_per_sr")).epsilon(1e-4));
    CHECK(phase_aerosol(demo(), nu) == doctest::Approx(table.number(i, "mie_g0.8_per_sr")).epsilon(1e-4));
  }
}

TEST_CASE("the aerosol can have the Henyey-Greenstein phase function") {
  AtmosphereParams p;
  p.mie.phase = "henyey-greenstein";
  p.mie.phase_g = 0.7;
  const AtmosphereUniform air = make_atmosphere_constants(p).data.air;
  for (const float nu : {-1.0f, -0.2f, 0.5f, 1.0f})
    CHECK(phase_aerosol(air, nu) == doctest::Approx(phase_hg(nu, 0.7f)));
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

TEST_CASE("panels of a path: in order, inside it, their weights add up to its length") {
  for (const RandomRay& ray : random_rays(2000)) {
    const bool ground = hits_ground_from(demo(), ray.h, ray.mu);
    const float length = ground ? distance_to_ground(demo(), ray.h, ray.mu) : distance_to_top(demo(), ray.h, ray.mu);
    const float mu_s = std::sin(37.0f * ray.h), nu = possible_nu(ray.mu, mu_s, std::cos(17.0f * ray.h));
    const PathPanels p = path_panels(demo(), ray.h, ray.mu, mu_s, nu, length, 0.7f * length);
    REQUIRE(p.count >= 1);
    REQUIRE(p.count <= 5);
    double sum = 0.0;
    float before = 0.0f;
    for (int panel = 0; panel < p.count; ++panel) {
      float low = 1e30f, high = -1e30f;
      for (int k = 0; k < 8; ++k) {
        const glm::vec2 node = path_node(p, panel, kGauss8X[k], kGauss8W[k]);
        low = std::min(low, node.x);
        high = std::max(high, node.x);
        sum += static_cast<double>(node.y);
      }
      CHECK(low >= before);
      before = high;
    }
    CHECK(before <= length);
    CHECK(sum == doctest::Approx(static_cast<double>(length)).epsilon(1e-5));
  }
}

TEST_CASE("a path is cut where it enters the planet's shadow") {
  // On the ground with the sun on the horizon, looking straight away from it along the horizontal: the shadow's edge is
  // the horizontal itself. Looking up by 10 degrees away from a sun 5 degrees low, the ray leaves the shadow at t:
  // |p|^2 - (p.s)^2 = R^2.
  const float mu = std::sin(10.0f * kPi / 180.0f), mu_s = std::sin(-5.0f * kPi / 180.0f);
  const float nu = std::cos((180.0f - 10.0f + 5.0f) * kPi / 180.0f);
  const float length = distance_to_top(demo(), 0.0f, mu);
  const PathPanels p = path_panels(demo(), 0.0f, mu, mu_s, nu, length, length);
  REQUIRE(p.count == 3);  // the cut of long paths at 200 km, and the shadow's edge
  CHECK(p.cut_m.x == kLongPath_m);
  const glm::dvec2 s(std::cos(-5.0 * 3.14159265358979 / 180.0), std::sin(-5.0 * 3.14159265358979 / 180.0));
  const double angle = (180.0 - 10.0) * 3.14159265358979 / 180.0, t = static_cast<double>(p.cut_m.y);
  const glm::dvec2 point = glm::dvec2(0.0, 6360000.0) + t * glm::dvec2(std::cos(angle), std::sin(angle));
  CHECK(std::sqrt(dot(point, point) - dot(point, s) * dot(point, s)) == doctest::Approx(6360000.0).epsilon(1e-7));
  // By day a long path has its cut alone, a short one none.
  CHECK(path_panels(demo(), 0.0f, mu, 0.5f, 0.2f, length, length).count == 2);
  CHECK(path_panels(demo(), 0.0f, mu, 0.5f, 0.2f, kLongPath_m, kLongPath_m).count == 1);
}

TEST_CASE(
    "texels of a sky view map to directions and back, from the horizon to the zenith, towards the light and away") {
  for (const float dip_deg : {0.02f, 0.5f, 3.0f, 10.0f}) {
    SkyView view{};
    const float dip_rad = dip_deg * kPi / 180.0f;
    view.horizon_t = std::tan(0.5f * dip_rad);
    view.split = sky_view_split(dip_rad);
    CHECK(sky_view_direction(view, {0.0f, 0.0f}).z == doctest::Approx(-std::sin(dip_rad)));
    CHECK(sky_view_direction(view, {0.3f, 1.0f}).z == doctest::Approx(1.0));
    float last = -1.0f;
    for (int i = 0; i < kSkyRows; ++i)
      for (int j = 0; j < kSkyAzimuths; ++j) {
        const glm::vec2 unit(unit_from_texel(j, kSkyAzimuths), unit_from_texel(i, kSkyRows));
        const glm::vec3 d = sky_view_direction(view, unit);
        CHECK(length(d) == doctest::Approx(1.0));
        if (j == 0) {
          CHECK(d.x >= 0.0f);
          CHECK(d.z > last);
          last = d.z;
        }
        const glm::vec2 back = sky_view_unit(view, 3.0f * d.x, -3.0f * d.y, 3.0f * d.z);  // any length, either side
        CHECK(std::abs(back.y - unit.y) < 3e-4f);
        if (i + 1 < kSkyRows) CHECK(std::abs(back.x - unit.x) < 1e-4f);  // at the zenith all azimuths are one
      }
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
      make_atmosphere_constants(p);
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
        }).starts_with("atmosphere.mie.extinction_per_m[0]"));
  CHECK(refused([](AtmosphereParams& p) { p.top_height_m = 5000.0; }).starts_with("atmosphere.top_height_m"));
  CHECK(refused([](AtmosphereParams& p) { p.scattering_orders = 0; }).starts_with("atmosphere.scattering_orders"));
}
