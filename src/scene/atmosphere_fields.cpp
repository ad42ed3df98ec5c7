#include "scene/atmosphere_fields.h"

#include "scene/field_ranges.h"

namespace nepho {

namespace {

void describe(FieldVisitor& v, RayleighParams& p) {
  v.leaf({.name = "scattering_per_m",
          .doc = "scattering coefficient at height 0; more makes the sky bluer and sunsets redder",
          .unit = "1/m",
          .range = closed(0, 1),
          .term = "beta_R; 1.24062e-6 lambda_um^-4 (Bruneton 2017)"},
         &p.scattering_per_m);
  v.leaf({.name = "scale_height_m",
          .doc = "height over which the density falls by e",
          .unit = "m",
          .range = closed(10, 1e6),
          .term = "H_R"},
         &p.scale_height_m);
}

void describe(FieldVisitor& v, MieParams& p) {
  v.leaf({.name = "scattering_per_m",
          .doc = "scattering coefficient of aerosol at height 0; more makes the air hazier",
          .unit = "1/m",
          .range = closed(0, 1),
          .term = "beta_M"},
         &p.scattering_per_m);
  v.leaf({.name = "extinction_per_m",
          .doc = "extinction coefficient of aerosol at height 0, not below scattering_per_m",
          .unit = "1/m",
          .range = closed(0, 1),
          .term = "beta_M / single-scattering albedo"},
         &p.extinction_per_m);
  v.leaf({.name = "scale_height_m",
          .doc = "height over which the density falls by e",
          .unit = "m",
          .range = closed(10, 1e6),
          .term = "H_M"},
         &p.scale_height_m);
  v.leaf({.name = "phase_g",
          .doc = "asymmetry of aerosol scattering; towards 1 the glow around the sun is smaller and brighter",
          .range = closed(-0.99, 0.99),
          .term = "g of Cornette-Shanks 1992, Henyey-Greenstein 1941"},
         &p.phase_g);
  v.leaf({.name = "phase",
          .doc = "phase function of aerosol; Cornette-Shanks has a little more light straight back and ahead",
          .term = "Cornette-Shanks 1992, Henyey-Greenstein 1941",
          .choices = {"cornette-shanks", "henyey-greenstein"}},
         &p.phase);
  v.leaf({.name = "optical_depth",
          .doc = "vertical optical depth of aerosol at 550 nm; sets the level of both coefficients, which keep their "
                 "spectrum and their ratio; null: as they are",
          .range = closed(0, 100),
          .term = "AOD, tau_a = beta_ext H_M"},
         &p.optical_depth);
  v.leaf({.name = "visibility_m",
          .doc = "meteorological visibility at height 0 and 550 nm, gas included, instead of optical_depth; null: "
                 "as the coefficients are",
          .unit = "m",
          .range = closed(10, 1e6),
          .term = "Koschmieder 1924, 3.912 / extinction"},
         &p.visibility_m);
}

void describe(FieldVisitor& v, OzoneParams& p) {
  v.leaf({.name = "absorption_per_m",
          .doc = "absorption coefficient where ozone is densest; more makes twilight bluer",
          .unit = "1/m",
          .range = closed(0, 1),
          .term = "300 Dobson units (Bruneton 2017)"},
         &p.absorption_per_m);
  v.leaf({.name = "center_m", .doc = "height where ozone is densest", .unit = "m", .range = closed(0, 1e6)},
         &p.center_m);
  v.leaf({.name = "half_width_m",
          .doc = "distance from there, up and down, over which the density falls to 0",
          .unit = "m",
          .range = closed(10, 1e6)},
         &p.half_width_m);
  v.leaf({.name = "column_du",
          .doc = "column of ozone, with the Earth's spectrum of absorption; null: as absorption_per_m is",
          .unit = "DU",
          .range = closed(0, 10000),
          .term = "total column ozone, Dobson units; the Earth has 200 to 500"},
         &p.column_du);
}

}  // namespace

void describe(FieldVisitor& v, AtmosphereParams& p) {
  v.preset({.name = "preset",
            .doc = "values of everything in this group that is not given here; saved scenes have the values themselves",
            .choices = atmosphere_preset_names(),
            .standard = "earth"},
           [&p](const std::string& name) {
             const std::optional<AtmosphereParams> preset = atmosphere_preset(name);
             if (preset) p = *preset;
             return preset.has_value();
           });
  v.leaf({.name = "equatorial_radius_m",
          .doc = "radius of the planet at its equator",
          .unit = "m",
          .range = closed(1e5, 1e9),
          .term = "a of WGS84"},
         &p.equatorial_radius_m);
  v.leaf({.name = "polar_radius_m",
          .doc = "radius of the planet at its poles",
          .unit = "m",
          .range = closed(1e5, 1e9),
          .term = "b of WGS84"},
         &p.polar_radius_m);
  v.leaf({.name = "top_height_m",
          .doc = "height above the ellipsoid where the air ends; at least 3 scale heights of gas and of aerosol",
          .unit = "m",
          .range = closed(1000, 1e6),
          .term = "top of the atmosphere (Bruneton 2017)"},
         &p.top_height_m);
  v.group({.name = "rayleigh", .doc = "scattering by the molecules of the air"}, [&] { describe(v, p.rayleigh); });
  v.group({.name = "mie", .doc = "scattering and absorption by aerosol"}, [&] { describe(v, p.mie); });
  v.group({.name = "ozone", .doc = "absorption by ozone"}, [&] { describe(v, p.ozone); });
  v.leaf({.name = "solar_irradiance_W_m2_nm",
          .doc = "spectral irradiance of the sun at 1 au, above the air",
          .unit = "W/(m^2 nm)",
          .range = closed(0, 50),
          .term = "ASTM G173 as in Bruneton 2017"},
         &p.solar_irradiance_W_m2_nm);
  v.leaf({.name = "ground_albedo",
          .doc = "mean reflectance of the ground that lights the sky from below",
          .range = share(),
          .term = "Lambertian albedo"},
         &p.ground_albedo);
  v.leaf({.name = "min_sun_zenith_cos",
          .doc = "cosine of the largest zenith angle of the sun that the tables hold; below it is night",
          .range = closed(-0.99, -0.01),
          .term = "mu_s_min (Bruneton 2017)"},
         &p.min_sun_zenith_cos);
  v.leaf({.name = "scattering_orders",
          .doc = "how often light is scattered at most; 1 is single scattering",
          .range = closed(1, 50),
          .term = "number of scattering orders"},
         &p.scattering_orders);
  v.leaf({.name = "spectral",
          .doc = "fast: three wavelengths; full: fifteen, summed to luminance, with truer colours",
          .term = "spectral rendering (Bruneton 2017)",
          .choices = {"fast", "full"}},
         &p.spectral);
}

void describe(FieldVisitor& v, NightSkyParams& p) {
  v.leaf({.name = "stars", .doc = "the stars of the Bright Star Catalogue, where marble-qt-data is installed"},
         &p.stars);
  v.leaf({.name = "moon", .doc = "the moon: its disc and its light"}, &p.moon);
  v.leaf({.name = "airglow_cd_m2",
          .doc = "luminance of the airglow layer seen vertically from below; the floor of the night",
          .unit = "cd/m^2",
          .range = closed(0, 1000),
          .term = "airglow (Leinert et al. 1998); 1e-4 is 22.6 mag/arcsec^2"},
         &p.airglow_cd_m2);
}

}  // namespace nepho
