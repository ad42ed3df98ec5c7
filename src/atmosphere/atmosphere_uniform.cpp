#include "atmosphere/atmosphere_uniform.h"

#include <cmath>
#include <numbers>

#include "atmosphere/luminance.h"
#include "atmosphere/spectrum.h"
#include "base/error.h"

namespace nepho {

static_assert(sizeof(shared::AtmosphereUniform) == 21 * 4);
static_assert(sizeof(shared::SpectralGroup) == (5 * 3 + 2 * 9 + 2 * 12) * 4);
static_assert(sizeof(shared::AtmosphereData) ==
              sizeof(shared::AtmosphereUniform) + shared::kMaxSpectralGroups * sizeof(shared::SpectralGroup));
static_assert(shared::kMaxSpectralGroups == kMaxSpectralGroups);

namespace {

/// Share of the air's height up to which a sky view resolves what a camera sees below the horizontal; higher up, rays
/// are integrated one by one.
constexpr double kSkyViewShare = 0.2;

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
  if (p.mie.phase != "cornette-shanks" && p.mie.phase != "henyey-greenstein")
    throw fail(ErrorKind::usage, "atmosphere.mie.phase: '{}' is not one of cornette-shanks, henyey-greenstein",
               p.mie.phase);
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

AtmosphereConstants make_atmosphere_constants(const AtmosphereParams& params) {
  const AtmosphereParams p = resolved(params);
  require_valid(p);
  const Spectrum spectrum = make_spectrum(p);
  AtmosphereConstants out;
  out.spectral_groups = spectrum.groups;
  out.data = {};
  shared::AtmosphereUniform& u = out.data.air;
  u.radius_m = static_cast<float>(p.equatorial_radius_m);
  u.top_m = static_cast<float>(p.top_height_m);
  u.rho_top_m = static_cast<float>(std::sqrt(p.top_height_m * (2.0 * p.equatorial_radius_m + p.top_height_m)));
  u.sun_angular_radius_rad = static_cast<float>(kSunAngularRadius_rad);
  u.rayleigh_scale_height_m = static_cast<float>(p.rayleigh.scale_height_m);
  u.mie_scale_height_m = static_cast<float>(p.mie.scale_height_m);
  u.ozone_center_m = static_cast<float>(p.ozone.center_m);
  u.ozone_half_width_m = static_cast<float>(p.ozone.half_width_m);
  const double g = p.mie.phase_g, one_minus = 1.0 - g * g;
  const bool henyey_greenstein = p.mie.phase == "henyey-greenstein";
  u.mie_g = static_cast<float>(g);
  u.mie_phase_k = static_cast<float>(henyey_greenstein ? one_minus / (4.0 * std::numbers::pi)
                                                       : 3.0 * one_minus / (8.0 * std::numbers::pi * (2.0 + g * g)));
  u.mie_phase_b = henyey_greenstein ? 0.0f : 1.0f;
  u.ground_albedo = static_cast<float>(p.ground_albedo);
  u.sky_view_top_m = static_cast<float>(kSkyViewShare * p.top_height_m);
  u.min_mu_s = static_cast<float>(p.min_sun_zenith_cos);
  u.mu_s_scale = shared::mu_s_scale_for(u, static_cast<float>(p.min_sun_zenith_cos));
  u.luminance_factor = spectrum.groups == 1 ? glm::vec3(sky_luminance_factors()) : glm::vec3(1.0f);
  u.sun_illuminance = sun_illuminance_at_1au(p);
  for (int i = 0; i < 3 * spectrum.groups; ++i) {
    shared::SpectralGroup& group = out.data.spectrum[i / 3];
    const int c = i % 3;
    const auto at = static_cast<size_t>(i);
    group.rayleigh_scattering_per_m[c] = static_cast<float>(spectrum.rayleigh_scattering_per_m[at]);
    group.mie_scattering_per_m[c] = static_cast<float>(spectrum.mie_scattering_per_m[at]);
    group.mie_extinction_per_m[c] = static_cast<float>(spectrum.mie_extinction_per_m[at]);
    group.ozone_absorption_per_m[c] = static_cast<float>(spectrum.ozone_absorption_per_m[at]);
    group.solar_irradiance[c] = static_cast<float>(spectrum.solar_irradiance[at]);
    for (int channel = 0; channel < 3; ++channel) {
      double sun = 0.0;
      for (size_t k = 0; k < 15 && k < static_cast<size_t>(3 * spectrum.groups); ++k)
        sun += spectrum.rgb[k][channel] * spectrum.solar_irradiance[k];
      const double mine = spectrum.rgb[at][channel] * spectrum.solar_irradiance[at];
      // With three wavelengths every channel is a wavelength, and the factors to luminance come last.
      const bool single = spectrum.groups == 1;
      group.rgb[c][channel] = static_cast<float>(single ? (channel == c ? 1.0 : 0.0) : spectrum.rgb[at][channel]);
      group.sun_share[c][channel] =
          static_cast<float>(single ? (channel == c ? 1.0 : 0.0) : (sun != 0.0 ? mine / sun : 0.0));
    }
    for (int k = 0; k < 4; ++k) {
      group.basis[k][c] = static_cast<float>(spectrum.basis[at][static_cast<size_t>(k)]);
      group.fit[c][k] = static_cast<float>(spectrum.fit[static_cast<size_t>(k)][at]);
    }
  }
  return out;
}

int spectral_groups(const AtmosphereParams& params) {
  if (params.spectral == "full") return kMaxSpectralGroups;
  if (params.spectral == "fast") return 1;
  throw fail(ErrorKind::usage, "atmosphere.spectral: '{}' is not one of fast, full", params.spectral);
}

}  // namespace nepho
