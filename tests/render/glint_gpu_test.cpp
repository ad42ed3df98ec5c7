// The sun's glint on the sea as seen from orbit, without air, against the closed form on the exact ellipsoid.
#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "astro/sky_bodies.h"
#include "atmosphere/luminance.h"
#include "gpu/gpu_fixture.h"
#include "render/frame_setup.h"
#include "render/renderer.h"
#include "terrain/terrain_fixture.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;

/// Unpolarised Fresnel reflectance of water, n = 1.34, from Snell's law.
double fresnel(double cos_i) {
  const double n = 1.34, sin_t = std::sqrt(1.0 - cos_i * cos_i) / n, cos_t = std::sqrt(1.0 - sin_t * sin_t);
  const double s = (cos_i - n * cos_t) / (cos_i + n * cos_t), p = (n * cos_i - cos_t) / (n * cos_i + cos_t);
  return 0.5 * (s * s + p * p);
}

/// Smith's shadowing of a Gaussian surface, exact; `sigma2` of one axis.
double lambda(double cos_theta, double sigma2) {
  const double nu = cos_theta / std::sqrt(2.0 * sigma2 * (1.0 - cos_theta * cos_theta));
  return 0.5 * (std::exp(-nu * nu) / (nu * std::sqrt(kPi)) - std::erfc(nu));
}

/// Cox and Munk 1954: reflected radiance per irradiance of the beam, 1/sr.
double glint(const dvec3& up, const dvec3& to_eye, const dvec3& to_sun, double wind_mps) {
  const double sigma2 = 0.5 * (0.003 + 0.00512 * wind_mps);
  const dvec3 h = glm::normalize(to_eye + to_sun);
  const double cos_beta = glm::dot(up, h), cos_v = glm::dot(up, to_eye), cos_s = glm::dot(up, to_sun);
  if (cos_v < 0.05 || cos_s < 0.05) return 0.0;
  const double tan2 = 1.0 / (cos_beta * cos_beta) - 1.0;
  const double p = std::exp(-0.5 * tan2 / sigma2) / (2.0 * kPi * sigma2);
  return fresnel(glm::dot(h, to_eye)) * p / (4.0 * cos_v * std::pow(cos_beta, 4)) /
         (1.0 + lambda(cos_v, sigma2) + lambda(cos_s, sigma2));
}

/// All sea, no air, no clouds.
Scene bare_sea() {
  Scene scene;
  setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
  scene.time = "2026-03-20T12:00:00Z";  // the sun is in the zenith at 0 N, 2 E
  scene.clouds = cloud_sky("clear").value();
  scene.night_sky.moon = scene.night_sky.stars = false;
  scene.night_sky.airglow_cd_m2 = 0.0;
  scene.atmosphere.rayleigh.scattering_per_m = scene.atmosphere.ozone.absorption_per_m = dvec3(0.0);
  scene.atmosphere.mie.scattering_per_m = scene.atmosphere.mie.extinction_per_m = dvec3(0.0);
  scene.atmosphere.scattering_orders = 1;
  scene.atmosphere.spectral = "fast";
  scene.camera.pitch_deg = -90.0;
  return scene;
}

}  // namespace

TEST_CASE("gpu: from orbit the glint lies at the specular point, as bright and as wide as the closed form has it") {
  struct View {
    double lat, lon, height_m, fov_deg, wind_mps;
    uint32_t width;
  };
  GpuFixture gpu;
  for (const View& v : {View{8.0, 20.0, 400e3, 90.0, 6.0, 96}, View{8.0, 20.0, 400e3, 90.0, 6.0, 24},
                        View{-5.0, 40.0, 35786e3, 20.0, 6.0, 96}, View{-5.0, 40.0, 35786e3, 20.0, 6.0, 24},
                        View{-5.0, 40.0, 35786e3, 20.0, 1.0, 96}}) {
    CAPTURE(v.height_m);
    CAPTURE(v.width);
    CAPTURE(v.wind_mps);
    Scene scene = bare_sea();
    scene.camera.lat_deg = v.lat;
    scene.camera.lon_deg = v.lon;
    scene.camera.height_m = v.height_m;
    scene.camera.fov_deg = v.fov_deg;
    scene.terrain.water_wind_mps = v.wind_mps;
    scene.render.width = scene.render.height = v.width;
    TerrainSources sources;
    sources.elevation = {test::raster_of(36, 18, {}, [](double, double) { return -100.0; })};
    sources.has_default = true;
    Renderer renderer(gpu.device, std::move(sources), scene);
    const RenderResult result = renderer.render({.display = false, .layers = true, .wanted = {}});
    const FrameLight light =
        FrameLight::from(sky_bodies_at(parse_utc(scene.time)), sun_illuminance_at_1au(scene.atmosphere), false);
    const shared::FrameConstants c =
        make_frame_constants(result.pose, {v.width, v.width}, light, 0.0, 0, 0, glm::vec2(0.0f));
    const dvec3 to_sun = glm::normalize(dvec3(c.sun_dir));
    const auto key = static_cast<double>(c.sun_illuminance.g);
    const std::vector<float>& g = result.layers.find("G")->values;
    FrameInfo frame;
    frame.extent = {v.width, v.width};
    frame.constants = c;
    double worst = 0.0, most = 0.0, lean = 9.0, sum = 0.0, x_drawn = 0.0, y_drawn = 0.0, x_true = 0.0, y_true = 0.0,
           sum_true = 0.0, specular_x = 0.0, specular_y = 0.0, brightest_true = 0.0;
    std::vector<double> expected(g.size()), drawn(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      const double x = static_cast<double>(i % v.width) + 0.5, y = static_cast<double>(i / v.width) + 0.5;
      const dvec3 ray = test::pixel_ray(frame, x, y);
      const double t = test::hit_ellipsoid(result.pose.ecef_m, ray);
      if (t < 0.0) continue;
      const Geodetic at = geodetic_from_ecef(result.pose.ecef_m + t * ray);
      const dvec3 up = geodetic_up_ecef(at.lat_rad, at.lon_rad);
      // What is not glint: light from below the surface, by the same sun; 0.0065 in green (shaders/common/water.h).
      const double body = 0.0065 / kPi * std::max(glm::dot(up, to_sun), 0.0);
      expected[i] = glint(up, -ray, to_sun, v.wind_mps);
      drawn[i] = static_cast<double>(g[i]) / key - body;
      brightest_true = std::max(brightest_true, expected[i]);
      const double apart = glm::length(glm::normalize(to_sun - ray) - up);
      if (apart < lean) {
        lean = apart;
        specular_x = x;
        specular_y = y;
      }
    }
    for (size_t i = 0; i < g.size(); ++i) {
      if (expected[i] < 0.3 * brightest_true) continue;
      const double x = static_cast<double>(i % v.width) + 0.5, y = static_cast<double>(i / v.width) + 0.5;
      worst = std::max(worst, std::abs(drawn[i] - expected[i]) / brightest_true);
      most = std::max(most, drawn[i]);
      sum += drawn[i];
      x_drawn += drawn[i] * x;
      y_drawn += drawn[i] * y;
      sum_true += expected[i];
      x_true += expected[i] * x;
      y_true += expected[i] * y;
    }
    REQUIRE(sum > 0.0);
    const double off_px = std::hypot(x_drawn / sum - x_true / sum_true, y_drawn / sum - y_true / sum_true);
    const double from_specular_px = std::hypot(x_drawn / sum - specular_x, y_drawn / sum - specular_y);
    MESSAGE(v.height_m << " m, " << v.width << " px, wind " << v.wind_mps << " m/s: brightest " << most << " of "
                       << brightest_true << " per sr, any pixel off by " << worst << " of that; centre off by "
                       << off_px << " px, " << from_specular_px << " px from the specular point");
    // The fits of Walter et al. (shadowing) and single precision; the body's share is (1 - F) of what was taken off.
    CHECK(worst < 0.02);
    CHECK(std::abs(sum / sum_true - 1.0) < 0.02);
    CHECK(off_px < 0.02 * v.width / 24.0);
    // 1 / cos and Fresnel draw the centre outwards from where a flat sea would mirror the sun.
    CHECK(from_specular_px < 0.1 * v.width);
  }
}
