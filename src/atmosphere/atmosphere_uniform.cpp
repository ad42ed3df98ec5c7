#include "atmosphere/atmosphere_uniform.h"

#include <cmath>

#include "atmosphere/luminance.h"
#include "base/error.h"

namespace nepho {

static_assert(sizeof(shared::AtmosphereUniform) == 32 * 4);

namespace {

/// Radius of the sun's disc at 1 au, rad (Bruneton 2017).
constexpr double kSunAngularRadius_rad = 0.00935 / 2.0;

void require(bool good, const char* name, double found, const char* wanted) {
  if (!good) throw fail(ErrorKind::usage, "atmosphere.{}: {} is not {}", name, found, wanted);
}
void require_in(const char* name, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw fail(ErrorKind::usage, "atmosphere.{}: {} is outside {}..{}", name, value, low, high);
}

void require_valid(const AtmosphereParams& p) {
  require_in("equatorial_radius_m", p.equatorial_radius_m, 1e5, 1e9);
  require_in("polar_radius_m", p.polar_radius_m, 0.5 * p.equatorial_radius_m, p.equatorial_radius_m);
  require_in("top_height_m", p.top_height_m, 1e3, 0.5 * p.equatorial_radius_m);
  require_in("rayleigh.scale_height_m", p.rayleigh.scale_height_m, 10.0, p.top_height_m);
  require_in("mie.scale_height_m", p.mie.scale_height_m, 10.0, p.top_height_m);
  require_in("ozone.half_width_m", p.ozone.half_width_m, 10.0, 1e6);
  require_in("ozone.center_m", p.ozone.center_m, -1e6, 1e6);
  require_in("mie.phase_g", p.mie.phase_g, -0.99, 0.99);
  require_in("ground_albedo", p.ground_albedo, 0.0, 1.0);
  require_in("min_sun_zenith_cos", p.min_sun_zenith_cos, -0.99, -0.01);
  require_in("scattering_orders", p.scattering_orders, 1, 1000);
  for (int c = 0; c < 3; ++c) {
    require_in("rayleigh.scattering_per_m", p.rayleigh.scattering_per_m[c], 0.0, 1.0);
    require_in("mie.extinction_per_m", p.mie.extinction_per_m[c], 0.0, 1.0);
    require_in("ozone.absorption_per_m", p.ozone.absorption_per_m[c], 0.0, 1.0);
    require_in("solar_irradiance_W_m2_nm", p.solar_irradiance_W_m2_nm[c], 0.0, 50.0);
    require(p.mie.scattering_per_m[c] >= 0.0 && p.mie.scattering_per_m[c] <= p.mie.extinction_per_m[c],
            "mie.scattering_per_m", p.mie.scattering_per_m[c], "between 0 and mie.extinction_per_m");
  }
}

}  // namespace

shared::AtmosphereUniform make_atmosphere_uniform(const AtmosphereParams& p) {
  require_valid(p);
  shared::AtmosphereUniform u{};
  u.radius_m = static_cast<float>(p.equatorial_radius_m);
  u.top_m = static_cast<float>(p.top_height_m);
  u.rho_top_m = static_cast<float>(std::sqrt(p.top_height_m * (2.0 * p.equatorial_radius_m + p.top_height_m)));
  u.sun_angular_radius_rad = static_cast<float>(kSunAngularRadius_rad);
  u.rayleigh_scattering_per_m = glm::vec3(p.rayleigh.scattering_per_m);
  u.rayleigh_scale_height_m = static_cast<float>(p.rayleigh.scale_height_m);
  u.mie_scattering_per_m = glm::vec3(p.mie.scattering_per_m);
  u.mie_scale_height_m = static_cast<float>(p.mie.scale_height_m);
  u.mie_extinction_per_m = glm::vec3(p.mie.extinction_per_m);
  u.mie_g = static_cast<float>(p.mie.phase_g);
  u.ozone_absorption_per_m = glm::vec3(p.ozone.absorption_per_m);
  u.ozone_center_m = static_cast<float>(p.ozone.center_m);
  u.ozone_half_width_m = static_cast<float>(p.ozone.half_width_m);
  u.solar_irradiance = glm::vec3(p.solar_irradiance_W_m2_nm);
  u.sky_luminance_factor = glm::vec3(sky_luminance_factors());
  u.sun_luminance_factor = glm::vec3(sun_luminance_factors());
  u.ground_albedo = static_cast<float>(p.ground_albedo);
  u.mu_s_scale = shared::mu_s_scale_for(u, static_cast<float>(p.min_sun_zenith_cos));
  return u;
}

}  // namespace nepho
