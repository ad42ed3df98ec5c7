#include "scene/cloud_fields.h"

#include <fmt/format.h>

#include "scene/field_ranges.h"
#include "scene/shadow_fields.h"

namespace nepho {

namespace {

const Range kWind = closed(-150.0, 150.0);  // the strongest jet streams reach 110 m/s
const Range kPeriods = closed(-1e6, 1e6);   // beyond it a shift in periods has no digits left for the fraction
const std::string kEastNorthUp = "east, north, up";
const std::string kTextureAxes = "along x, y, z of the texture";

/// Names of other libraries are those of @takram/three-clouds: its CloudLayer, its CloudsEffect's properties.
void describe(FieldVisitor& v, DensityProfile& p) {
  v.leaf({.name = "exp_term",
          .doc = "factor a of the exponential",
          .range = closed(-100, 100),
          .other_names = "densityProfile.expTerm"},
         &p.exp_term);
  v.leaf({.name = "exponent",
          .doc = "exponent b per thickness; above 0 the top is denser, below 0 the base",
          .range = closed(-50, 50),
          .other_names = "densityProfile.exponent"},
         &p.exponent);
  v.leaf({.name = "linear_term",
          .doc = "growth c from base to top; clouds of rising air hold more water higher up",
          .range = closed(-100, 100),
          .term = "adiabatic liquid water content",
          .other_names = "densityProfile.linearTerm"},
         &p.linear_term);
  v.leaf({.name = "constant_term",
          .doc = "density d at the base, besides that of the exponential",
          .range = closed(-100, 100),
          .other_names = "densityProfile.constantTerm"},
         &p.constant_term);
}

/// Where a layer is and what it is made of.
void describe_body(FieldVisitor& v, CloudLayer& p) {
  v.leaf({.name = "weather_channel",
          .doc = "channel of the weather map whose coverage the layer has; layers of one channel share their noise too",
          .term = "channel of the weather texture (Schneider 2015)",
          .other_names = "channel",
          .choices = {"r", "g", "b", "a"}},
         &p.weather_channel);
  v.leaf({.name = "coverage_scale",
          .doc = "the layer's coverage is this times the weather's, at most 1",
          .range = closed(0, 2)},
         &p.coverage_scale);
  v.leaf({.name = "base_m",
          .doc = "height of the base above base_reference",
          .unit = "m",
          .range = closed(-5000, 1e5),
          .term = "cloud base height",
          .other_names = "altitude"},
         &p.base_m);
  v.leaf({.name = "base_reference",
          .doc = "what base_m is measured from: the ellipsoid, mean sea level, or the ground smoothed over some 20 km",
          .term = "ellipsoidal height, height above the geoid, above ground level",
          .choices = {"ellipsoid", "msl", "terrain"}},
         &p.base_reference);
  v.leaf({.name = "thickness_m",
          .doc = "height of the top above the base; 0 leaves the layer out",
          .unit = "m",
          .range = closed(0, 1e5),
          .term = "geometrical thickness",
          .other_names = "height"},
         &p.thickness_m);
  v.leaf(
      {.name = "density_scale",
       .doc = "times scattering_per_m and absorption_per_m; more darkens bases and hardens edges; 0 leaves the layer "
              "out",
       .range = closed(0, 100),
       .term = "density multiplier (Schneider 2015)",
       .other_names = "densityScale"},
      &p.density_scale);
  v.group({.name = "density_profile",
           .doc = "density over the relative height eta, 0 the base and 1 the top: exp_term * exp(exponent * eta) + "
                  "linear_term * eta + constant_term, cut at 0; somewhere above 0",
           .term = "density-altering height function (Haggstrom 2018)",
           .other_names = "densityProfile"},
          [&] { describe(v, p.density_profile); });
}

/// Its form.
void describe_form(FieldVisitor& v, CloudLayer& p) {
  v.leaf({.name = "shape_amount",
          .doc = "how much the shape noise carves and swells",
          .range = share(),
          .term = "base shape noise (Schneider 2015)",
          .other_names = "shapeAmount"},
         &p.shape_amount);
  v.leaf({.name = "detail_amount",
          .doc = "how much the detail noise works on the edges: wisps below, billows above",
          .range = share(),
          .term = "detail erosion (Schneider 2015)",
          .other_names = "shapeDetailAmount"},
         &p.detail_amount);
  v.leaf({.name = "weather_exponent",
          .doc = "a value v of the weather map means the coverage v^exponent; above 1 thin cover goes first",
          .range = closed(0.05, 20),
          .term = "contrast of the weather map",
          .other_names = "weatherExponent"},
         &p.weather_exponent);
  v.leaf({.name = "shape_altering_bias",
          .doc = "the cloud is widest at the relative height 0.5^(1/bias): a low bias widens the base",
          .range = closed(0.05, 10),
          .term = "shape-altering height function (Haggstrom 2018)",
          .other_names = "shapeAlteringBias"},
         &p.shape_altering_bias);
  v.leaf({.name = "coverage_filter_width",
          .doc = "standard deviations of the noise from a cloud's edge to its full density; more softens edges",
          .range = closed(0.01, 10),
          .term = "remap of noise by coverage (Schneider 2015)",
          .other_names = "coverageFilterWidth"},
         &p.coverage_filter_width);
  v.leaf(
      {.name = "top_relief",
       .doc = "standard deviations by which a cell must exceed the edge to fill 63 % of the layer; 0 gives even tops",
       .range = closed(0, 10),
       .term = "cloud type, gradient of coverage over height (Schneider 2015)"},
      &p.top_relief);
  v.leaf({.name = "anvil_amount",
          .doc = "how much wider the top fifth is than the tower below it",
          .range = share(),
          .term = "anvil amount (Haggstrom 2018); incus"},
         &p.anvil_amount);
  v.leaf({.name = "cell_size_m",
          .doc = "distance between neighbouring cells",
          .unit = "m",
          .range = closed(50, 1e6),
          .term = "wavelength of cellular convection"},
         &p.cell_size_m);
  v.leaf({.name = "cell_roundness",
          .doc = "0 a fractal field, 1 rounded cells with creases between them",
          .range = share(),
          .term = "Perlin noise against cellular noise (Worley 1996)"},
         &p.cell_roundness);
  v.leaf({.name = "stretch",
          .doc = "elongation of cells and noise along parallels: 1 none, 8 the fibres of cirrus",
          .range = closed(1, 50),
          .term = "anisotropy"},
         &p.stretch);
  v.leaf({.name = "cover_optical_depth",
          .doc = "vertical optical depth from which sky counts as covered; cirrus 0.1",
          .range = closed(0.001, 100),
          .term = "threshold of cloud fraction"},
         &p.cover_optical_depth);
  v.leaf({.name = "casts_shadow", .doc = "whether the ground lies in its shade", .other_names = "shadow"},
         &p.casts_shadow);
}

/// Its motion.
void describe_motion(FieldVisitor& v, CloudLayer& p) {
  v.leaf({.name = "wind_east_mps",
          .doc = "eastward wind at the layer's base",
          .unit = "m/s",
          .range = kWind,
          .term = "zonal wind u",
          .other_names = "localWeatherVelocity"},
         &p.wind_east_mps);
  v.leaf({.name = "wind_north_mps",
          .doc = "northward wind at the layer's base",
          .unit = "m/s",
          .range = kWind,
          .term = "meridional wind v",
          .other_names = "localWeatherVelocity"},
         &p.wind_north_mps);
  v.leaf({.name = "shear_east_mps_per_km",
          .doc = "change of the eastward wind with height; tops lean by what ten minutes of it make",
          .unit = "m/s/km",
          .range = closed(-50, 50),
          .term = "wind shear du/dz; skew by wind (Schneider 2015)"},
         &p.shear_east_mps_per_km);
  v.leaf({.name = "shear_north_mps_per_km",
          .doc = "change of the northward wind with height",
          .unit = "m/s/km",
          .range = closed(-50, 50),
          .term = "wind shear dv/dz"},
         &p.shear_north_mps_per_km);
  v.leaf({.name = "evolution_speed",
          .doc = "0 the pattern only moves; 1 cells form and dissolve in some 40 minutes",
          .range = closed(0, 10),
          .term = "inverse lifetime of a cell"},
         &p.evolution_speed);
}

void describe(FieldVisitor& v, CloudLayer& p) {
  v.preset({.name = "genus",
            .doc = "values of everything in this layer that is not given here; without it those below; saved scenes "
                   "have the values themselves",
            .term = "cloud genera (WMO International Cloud Atlas)",
            .choices = cloud_genus_names()},
           [&p](const std::string& name) {
             const std::optional<CloudLayer> genus = cloud_genus(name);
             if (genus) p = *genus;
             return genus.has_value();
           });
  describe_body(v, p);
  describe_form(v, p);
  describe_motion(v, p);
}

/// `library` begins the names of other libraries: shape, shapeDetail, turbulence.
void describe(FieldVisitor& v, NoiseTextureParams& p, const std::string& term, const std::string& library) {
  v.leaf({.name = "file",
          .doc = "volume to read instead of the built-in one; empty: none",
          .term = term,
          .other_names = library + "Texture",
          .text = TextKind::optional_file},
         &p.file);
  v.leaf({.name = "period_m",
          .doc = "distance after which it repeats",
          .unit = "m",
          .range = closed(1, 1e6),
          .term = "inverse frequency",
          .other_names = library + (library == "turbulence" ? "Repeat (per repeat of the local weather)"
                                                            : "Repeat = 1 / period_m")},
         &p.period_m);
  v.leaf({.name = "offset",
          .doc = "shift",
          .unit = "periods",
          .range = kPeriods,
          .other_names = library == "turbulence" ? "" : library + "Offset",
          .components = kTextureAxes},
         &p.offset);
  v.leaf({.name = "velocity_mps",
          .doc = "motion relative to the layer's wind",
          .unit = "m/s",
          .range = kWind,
          .other_names = library == "turbulence" ? "" : library + "Velocity",
          .components = kEastNorthUp},
         &p.velocity_mps);
  v.leaf({.name = "displacement_m",
          .doc = library == "turbulence" ? "how far turbulence is displaced by itself"
                                         : "how far turbulence moves its lookups, at a layer's base",
          .unit = "m",
          .range = closed(0, 1e5),
          .term = "distortion by curl noise (Schneider 2015)",
          .other_names = library == "shape" ? "turbulenceDisplacement" : ""},
         &p.displacement_m);
}

void describe(FieldVisitor& v, CloudNoiseParams& p) {
  v.group({.name = "shape", .doc = "the volume that gives clouds their billows"},
          [&] { describe(v, p.shape, "Perlin-Worley noise, 128^3 (Schneider 2015)", "shape"); });
  v.group({.name = "detail", .doc = "the volume that gives edges their wisps and knobs"},
          [&] { describe(v, p.detail, "Worley noise, 32^3 (Worley 1996, Schneider 2015)", "shapeDetail"); });
  v.group({.name = "turbulence", .doc = "the vectors that distort the other two at the bases"},
          [&] { describe(v, p.turbulence, "curl noise, 64^3 (Bridson 2007)", "turbulence"); });
  v.leaf({.name = "blue_noise_file",
          .doc = "slices to read instead of the built-in ones; empty: none",
          .term = "spatiotemporal blue noise (Wolfe 2022)",
          .other_names = "stbnTexture",
          .text = TextKind::optional_file},
         &p.blue_noise_file);
}

void describe(FieldVisitor& v, WeatherParams& p) {
  v.leaf({.name = "source",
          .doc = "procedural: a climate of its own; raster: a map of the globe; tile: a texture that repeats over it",
          .term = "weather texture (Schneider 2015)",
          .other_names = "localWeatherTexture (tile)",
          .choices = {"procedural", "raster", "tile"}},
         &p.source);
  v.leaf({.name = "file",
          .doc = "of raster and tile: cloud cover in one band for all channels, or up to four bands for R, G, B, A",
          .other_names = "localWeatherTexture",
          .text = TextKind::optional_file},
         &p.file);
  v.leaf({.name = "seed",
          .doc = "another number, another planet's weather, and other noise",
          .range = closed(0, 4294967295.0)},
         &p.seed);
  v.leaf({.name = "contrast",
          .doc = "procedural: how far the weather departs from the means; 0 the same everywhere, 0.9 clear deserts "
                 "beside overcast storms",
          .range = closed(0, 0.95)},
         &p.contrast);
  const struct {
    const char *name, *clouds;
    double* value;
  } means[] = {{"mean_coverage_r", "low clouds", &p.mean_coverage_r},
               {"mean_coverage_g", "middle clouds", &p.mean_coverage_g},
               {"mean_coverage_b", "high clouds", &p.mean_coverage_b},
               {"mean_coverage_a", "deep convection", &p.mean_coverage_a}};
  for (const auto& mean : means)
    v.leaf({.name = mean.name,
            .doc = fmt::format("procedural: mean coverage of the globe by {}", mean.clouds),
            .range = share(),
            .term = "cloud fraction"},
           mean.value);
  v.leaf({.name = "drift_east_mps",
          .doc = "the whole map turns about the polar axis, at this speed on the equator, since 2000-01-01",
          .unit = "m/s",
          .range = kWind,
          .term = "zonal wind u",
          .other_names = "localWeatherVelocity"},
         &p.drift_east_mps);
  v.leaf({.name = "tile_period_m",
          .doc = "tile: distance after which the texture repeats",
          .unit = "m",
          .range = closed(1000, 4e7),
          .other_names = "localWeatherRepeat = globe / tile_period_m"},
         &p.tile_period_m);
  v.leaf({.name = "tile_offset",
          .doc = "tile: shift",
          .unit = "periods",
          .range = kPeriods,
          .other_names = "localWeatherOffset",
          .components = "along ECEF x, y, z"},
         &p.tile_offset);
}

void describe_light(FieldVisitor& v, CloudParams& p) {
  v.leaf({.name = "scattering_per_m",
          .doc = "scattering coefficient at density 1; more darkens bases and hardens edges",
          .unit = "1/m",
          .range = closed(0, 10),
          .term = "sigma_s",
          .other_names = "scatteringCoefficient"},
         &p.scattering_per_m);
  v.leaf({.name = "absorption_per_m",
          .doc = "absorption coefficient at density 1; droplets hardly absorb light",
          .unit = "1/m",
          .range = closed(0, 10),
          .term = "sigma_a",
          .other_names = "absorptionCoefficient"},
         &p.absorption_per_m);
  v.leaf({.name = "phase",
          .doc = "phase function of droplets: dual_hg, two Henyey-Greenstein lobes; cornette_shanks, the forward one "
                 "Cornette-Shanks; mie, a fit to droplets of droplet_diameter_um, which asks for none of phase_*",
          .term = "Henyey-Greenstein 1941; Cornette-Shanks 1992; HG + Draine (Jendersie and d'Eon 2023)",
          .choices = {"dual_hg", "cornette_shanks", "mie"}},
         &p.phase);
  v.leaf({.name = "droplet_diameter_um",
          .doc = "of phase mie: diameter of the droplets; larger ones have a narrower forward peak",
          .unit = "um",
          .range = closed(5, 50),
          .term = "d of Jendersie and d'Eon 2023"},
         &p.droplet_diameter_um);
  v.leaf({.name = "phase_g_forward",
          .doc = "asymmetry of the forward lobe of scattering by droplets; towards 1 the silver lining is brighter",
          .range = open(-1, 1),
          .term = "g of Henyey-Greenstein 1941, of Cornette-Shanks 1992",
          .other_names = "scatterAnisotropy1"},
         &p.phase_g_forward);
  v.leaf({.name = "phase_g_backward",
          .doc = "asymmetry of the backward lobe; towards -1 clouds opposite the sun are brighter",
          .range = open(-1, 1),
          .term = "g of Henyey-Greenstein 1941",
          .other_names = "scatterAnisotropy2"},
         &p.phase_g_backward);
  v.leaf({.name = "phase_backward_weight",
          .doc = "share of the backward lobe",
          .range = share(),
          .term = "two-lobe Henyey-Greenstein (Kattawar 1975)",
          .other_names = "scatterAnisotropyMix"},
         &p.phase_backward_weight);
  v.leaf({.name = "multiple_scattering",
          .doc = "light scattered more than once, but for quality reference: cells, that fan out from the camera and "
                 "hold traced light; octaves, "
                 "eight copies of single scattering with factors 0.5, for comparison",
          .term = "octaves: multiple scattering approximation (Wrenninge 2013)",
          .choices = {"cells", "octaves"}},
         &p.multiple_scattering);
  v.leaf({.name = "sky_light_scale",
          .doc = "times the light that the sky throws on clouds; 1 is physical",
          .range = closed(0, 10),
          .term = "ambient term (Schneider 2015)",
          .other_names = "skyLightScale"},
         &p.sky_light_scale);
  v.leaf({.name = "ground_bounce_scale",
          .doc = "times the light that the ground throws back; 1 is physical",
          .range = closed(0, 10),
          .other_names = "groundBounceScale"},
         &p.ground_bounce_scale);
  v.leaf({.name = "multiple_scattering_weight",
          .doc = "artist's option, not of quality reference: sunlight (moonlight) scattered more than once in clouds, "
                 "times this; 0 is single scattering alone, 1 is physical",
          .range = closed(0, 4)},
         &p.multiple_scattering_weight);
  v.leaf({.name = "powder",
          .doc = "artist's option, not of quality reference: darker edges and up to twice as bright insides, seen with "
                 "the sun behind; 0 is physical",
          .range = share(),
          .term = "Beer-powder (Schneider 2015)",
          .other_names = "powderScale"},
         &p.powder);
  v.leaf(
      {.name = "sun_taps",
       .doc = "looks at the density towards the sun, but for quality reference: near, a few along the way; cone, six "
              "within a widening cone, the last far away, for comparison",
       .term = "cone-sampled lighting (Schneider 2015)",
       .choices = {"near", "cone"}},
      &p.sun_taps);
}

}  // namespace

void describe(FieldVisitor& v, CloudParams& p) {
  v.preset(
      {.name = "preset",
       .doc = "a sky: values of everything in this group that is not given here, its layers included; saved scenes "
              "have the values themselves",
       .choices = cloud_sky_names(),
       .standard = "earth"},
      [&p](const std::string& name) {
        const std::optional<CloudParams> sky = cloud_sky(name);
        if (sky) p = *sky;
        return sky.has_value();
      });
  v.leaf({.name = "coverage",
          .doc = "the same weather everywhere, of this coverage: vertically projected share of the sky whose optical "
                 "depth is above "
                 "cover_optical_depth; 0 is clear; null: the weather's own",
          .range = share(),
          .term = "cloud fraction",
          .other_names = "coverage"},
         &p.coverage);
  v.items({.name = "layers", .doc = "cloud layers, marched together", .standard = "those of the preset earth"},
          {.list = true,
           .max = 4,
           .size = [&p] { return p.layers.size(); },
           .resize =
               [&p](size_t n) {
                 p.layers.clear();
                 p.layers.resize(n);
               },
           .visit = [&p](FieldVisitor& visitor, size_t i) { describe(visitor, p.layers[i]); },
           .visit_default =
               [](FieldVisitor& visitor) {
                 CloudLayer defaults;
                 describe(visitor, defaults);
               }});
  v.group({.name = "weather", .doc = "where the large-scale weather comes from"}, [&] { describe(v, p.weather); });
  v.group({.name = "noise", .doc = "the textures that give clouds their form"}, [&] { describe(v, p.noise); });
  v.group({.name = "shadows", .doc = "shadow maps of the clouds"}, [&] { describe(v, p.shadows); });
  describe_light(v, p);
  v.leaf({.name = "uniform_density",
          .doc = "above 0 the first layer is an even slab of this density, for tests of the march",
          .range = closed(0, 10)},
         &p.uniform_density);
}

}  // namespace nepho
