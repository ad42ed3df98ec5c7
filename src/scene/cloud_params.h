#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/shadow_params.h"

namespace nepho {

/// Density over the relative height eta (0 the base, 1 the top): exp_term * exp(exponent * eta) + linear_term * eta +
/// constant_term, cut at 0.
struct DensityProfile {
  double exp_term = 0.0;
  double exponent = 0.0;
  double linear_term = 0.75;
  double constant_term = 0.25;
  bool operator==(const DensityProfile&) const = default;
};

/// One cloud layer. Names follow docs/clouds.md; the defaults are a cumulus.
struct CloudLayer {
  std::string weather_channel = "r";  ///< of the weather map: r, g, b, a; layers may share one, and then its noise too
  double coverage_scale = 1.0;        ///< the layer's coverage is this times the weather's, 0..2
  double base_m = 1500.0;             ///< height of the base above `base_reference`, m
  std::string base_reference = "ellipsoid";  ///< ellipsoid, msl (geoid), terrain (ground smoothed over some 20 km)
  double thickness_m = 1600.0;               ///< m, >= 0; 0 leaves the layer out
  double density_scale = 1.0;  ///< times the scattering and absorption coefficients, >= 0; 0 leaves it out
  DensityProfile density_profile = {};
  double shape_amount = 1.0;          ///< 0..1: how much the shape noise carves and swells
  double detail_amount = 0.5;         ///< 0..1: how much the detail noise works on edges
  double weather_exponent = 1.0;      ///< a weather map's value v means the coverage v^exponent, > 0
  double shape_altering_bias = 0.35;  ///< where the cloud is widest: eta = 0.5^(1 / bias), > 0
  double coverage_filter_width =
      0.12;  ///< standard deviations of the field from a cloud's edge to its full density, > 0
  double top_relief =
      1.15;  ///< standard deviations by which a cell must exceed the edge to fill 63 % of the layer, >= 0
  double anvil_amount = 0.0;         ///< 0..1: how much wider the top fifth is than the tower below it
  double cell_size_m = 2500.0;       ///< distance between neighbouring cells, m
  double cell_roundness = 1.0;       ///< 0 a fractal field, 1 rounded cells with creases between
  double stretch = 1.0;              ///< elongation of cells and noise along parallels: 1 none; 8 the fibres of cirrus
  double cover_optical_depth = 1.0;  ///< vertical optical depth from which sky counts as covered: 1; cirrus 0.1
  bool casts_shadow = true;
  double wind_east_mps = 0.0;           ///< of the layer's base, m/s
  double wind_north_mps = 0.0;          ///< m/s
  double shear_east_mps_per_km = 0.0;   ///< change of the wind with height: tops lean by what ten minutes of it make
  double shear_north_mps_per_km = 0.0;  ///< m/s per km
  double evolution_speed = 1.0;  ///< 0 the pattern only moves; 1 cells form and dissolve in some 40 minutes; 0..10
  bool operator==(const CloudLayer&) const = default;
};

/// A tileable noise volume: made on the GPU, or read from a file (docs/cloud_noise.md).
struct NoiseTextureParams {
  std::string file = {};         ///< empty: the built-in one
  double period_m = 6130.0;      ///< distance after which it repeats, m ("repeat" of other libraries: 1 / period)
  glm::dvec3 offset{0.0};        ///< shift along its own axes, in periods
  glm::dvec3 velocity_mps{0.0};  ///< east, north, up, relative to the layer's wind, m/s
  double displacement_m = 0.0;   ///< how far turbulence moves its lookups, m
  bool operator==(const NoiseTextureParams&) const = default;
};

/// The textures that give clouds their form.
struct CloudNoiseParams {
  NoiseTextureParams shape{.period_m = 6130.0, .displacement_m = 70.0};  ///< 128^3 Perlin-Worley
  NoiseTextureParams detail{.period_m = 497.0, .displacement_m = 30.0};  ///< 32^3 Worley
  NoiseTextureParams turbulence{.period_m = 2390.0};                     ///< 64^3, a divergence-free vector
  std::string blue_noise_file;                                           ///< empty: the built-in one, 64 x 64 x 16
  bool operator==(const CloudNoiseParams&) const = default;
};

/// Where the large-scale weather comes from.
struct WeatherParams {
  std::string source = "procedural";  ///< procedural; raster: a map of the globe; tile: a tileable RGBA texture
  std::string file;                   ///< of raster and tile
  uint32_t seed = 12;                 ///< another number, another planet's weather, and other noise
  double contrast = 0.75;             ///< procedural: how far it departs from the means, 0..0.95; 0 the same everywhere
  double mean_coverage_r = 0.40;      ///< procedural: mean over the globe of the low clouds, 0..1
  double mean_coverage_g = 0.25;      ///< of the middle clouds
  double mean_coverage_b = 0.30;      ///< of the high clouds
  double mean_coverage_a = 0.06;      ///< of deep convection
  double drift_east_mps = 0.0;   ///< the map turns about the polar axis, m/s at the equator, since 2000-01-01T12:00Z
  double tile_period_m = 300e3;  ///< tile: distance after which the texture repeats, m
  glm::dvec3 tile_offset{0.0};   ///< tile: shift along ECEF axes, in periods
  bool operator==(const WeatherParams&) const = default;
};

/// The sky's clouds.
struct CloudParams {
  /// The same coverage everywhere: vertically projected share of the sky with optical depth > 1 (a layer's
  /// cover_optical_depth), 0..1; 0 is clear. Without: the weather's own.
  std::optional<double> coverage;
  std::vector<CloudLayer> layers = {CloudLayer{}};  ///< up to four, marched together
  WeatherParams weather;
  CloudNoiseParams noise;
  CloudShadowParams shadows;
  double scattering_per_m = 0.04;  ///< scattering coefficient at density 1, 1/m, >= 0
  double absorption_per_m = 0.0;   ///< absorption coefficient at density 1, 1/m, >= 0
  /// Phase function of droplets: dual_hg; cornette_shanks, the same with a forward lobe of Cornette and Shanks; mie, a
  /// fit to droplets of droplet_diameter_um.
  std::string phase = "dual_hg";
  double phase_g_forward = 0.85;       ///< forward lobe, (-1, 1); not of mie
  double phase_g_backward = -0.2;      ///< backward Henyey-Greenstein lobe; not of mie
  double phase_backward_weight = 0.1;  ///< 0..1; not of mie
  double droplet_diameter_um = 20.0;   ///< of mie, micrometres, 5..50
  /// Light scattered more than once, in all qualities but reference: cells; octaves, as other renderers have it.
  std::string multiple_scattering = "cells";
  double sky_light_scale = 1.0;      ///< times the light that the sky throws on clouds, 0..10
  double ground_bounce_scale = 1.0;  ///< times the light that the ground throws back, 0..10
  /// Artist's options; quality reference ignores them. Light of the key light that was scattered more than once, times
  /// this: 0 single scattering alone, 1 physical; 0..4.
  double multiple_scattering_weight = 1.0;
  double powder = 0.0;            ///< darker edges that face the light (Schneider 2015), 0 off .. 1
  std::string sun_taps = "near";  ///< looks at the density towards the light: near, along it; cone, around it
  double uniform_density = 0.0;   ///< > 0: the first layer is an even slab of this density; tests of the march
  bool operator==(const CloudParams&) const = default;
};

/// A layer of the genus: stratus, stratocumulus, cumulus, altocumulus, cirrus, cumulonimbus, fog; nothing for other
/// names.
std::optional<CloudLayer> cloud_genus(const std::string& name);
std::vector<std::string> cloud_genus_names();

/// A whole sky: layers, and coverage where it is the same everywhere. earth (the default: procedural weather), clear,
/// fair, broken, overcast, storm, high-cirrus, valley-fog, or the name of a genus: that layer alone.
std::optional<CloudParams> cloud_sky(const std::string& name);
std::vector<std::string> cloud_sky_names();

}  // namespace nepho
