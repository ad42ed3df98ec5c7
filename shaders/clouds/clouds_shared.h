// Data and pure functions of the cloud model, for C++ and GLSL (docs/clouds.md uses these names).
#ifndef NEPHO_CLOUDS_SHARED_H
#define NEPHO_CLOUDS_SHARED_H
#include "common/phase.h"
#include "common/planet.h"
#include "weather/weather_shared.h"
SHARED_BEGIN

SHARED_CONST uint kCloudLayers = 4u;

// Where one noise is read: its lattice, turned, scaled and stretched against ECEF metres. Layers of one weather channel and
// the same sizes have the same lattices, so that their clouds stand over each other.
SHARED_CONST uint kDomainTurbulence = 0u;  // turbulence: churns what is smaller
SHARED_CONST uint kDomainTile = 1u;        // the weather tile, one repeat to 1
SHARED_CONST uint kDomainOfLayer = 2u;     // the first of each layer's:
SHARED_CONST uint kRegional = 0u;          // field, 60..3 km
SHARED_CONST uint kMeso = 1u;              // field, 13..1 km at the size of cumulus
SHARED_CONST uint kCell = 2u;              // cells: cell_size_m
SHARED_CONST uint kShape = 3u;             // shape
SHARED_CONST uint kDetail = 4u;            // detail
SHARED_CONST uint kFine = 5u;              // detail again, smaller
SHARED_CONST uint kLayerDomains = 6u;
SHARED_CONST uint kCloudDomains = 26u;  // kDomainOfLayer + kCloudLayers * kLayerDomains
SHARED_CONST uint kCloudPhases = 2u;

struct CloudDomain {
  mat3 uvw_from_ecef;  // 1/m
  float log2_texel_m;  // log2 of a texel's size
};

// What depends on camera and time. The pattern of a window of twelve hours is carried along by the wind and evolves from
// the window's middle on; around a window's ends two patterns overlap (docs/clouds.md, 'Time').
struct CloudAnchor {
  vec3 offsets[52];          // per domain and phase: the camera's own coordinate, reduced modulo 1 in double
  vec2 age_s;                // time since the middle of each phase's window
  vec2 weight;               // of each phase; their squares add to 1
  mat3 weather_from_ecef;    // turn of the weather map by its drift, scaled axes
};

struct CloudLayerConstants {
  float base_m;                // above the reference
  float thickness_m;
  float extinction_per_m;      // at density 1 of the profile
  float shape_amount;
  float detail_amount;
  float filter_width;          // of the level, from edge to full density
  float top_relief;
  float anvil_amount;
  float altering_bias;
  float cell_roundness;
  float cell_size_m;
  float cover_optical_depth;
  float weather_exponent;
  float coverage_scale;
  float geoid_weight;          // of the ground map's two heights in the base
  float ground_weight;
  float regional_weight;       // standard deviations of the fields; their squares add to 1
  float meso_weight;
  float cell_weight;
  vec4 channel;                // 1 for the layer's weather channel
  vec4 profile;                // a, b, c, d of a exp(b eta) + c eta + d
  vec2 wind_mps;               // east, north, of the base
  vec2 lean;                   // horizontal offset per metre of height
  float evolution_mps;         // the pattern's slice moves so fast through its noise
  float step_m;                // shortest useful step of a march
  vec2 bend_m;                 // displacement of cells and billows by the regional and the meso field, m per standard deviation
  float thresholds[16];        // calibrated: probit that gives the coverage of probit kThresholdFirst + i * kThresholdStep
  uint slot;                   // which of the scene's layers this is: 0..3
};
SHARED_CONST float kThresholdFirst = -3.0f;
SHARED_CONST float kThresholdStep = 0.4f;

// Fades of the noises: variance_left(lod, start, per_lod).
struct CloudFades {
  vec2 field, cells_round, cells_fractal, shape, detail;
};

struct CloudConstants {
  CloudDomain domains[26];
  CloudLayerConstants layers[4];  // the drawing ones first
  CloudAnchor anchor;
  CloudFades fades;
  uint layer_count;
  uint caster_count;              // of the layers that cast shadows
  uint casters[4];
  float hull_low_m, hull_high_m;  // geodetic heights between which all clouds are
  float uniform_coverage;
  float log2_weather_texel_m;
  float single_scattering_albedo;
  float extinction_unit_per_m;    // extinction at density 1
  PhaseLobes phase;
  float multiple_scattering_weight;
  float powder;
  float uniform_density;          // > 0: the first layer is a slab of this density (a test of the march)
  float shape_displacement_m, detail_displacement_m, fine_displacement_m;
  vec3 shape_velocity_mps, detail_velocity_mps;  // east, north, up, relative to the wind
};

// A point to be looked at through its own camera (probes).
struct CloudCase {
  PlanetView planet;
  vec3 p_cam;        // the point, relative to the camera, ECEF axes, m
  float footprint_m;
  CloudAnchor anchor;
};

// Variance that a noise keeps at a level of detail, as a smooth step down from `start`; fitted to its mips (cloud_noise.cpp).
SHARED_FN float variance_left(float lod, float start, float per_lod) {
  float u = clamp((lod - start) * per_lod, 0.0f, 1.0f);
  return 1.0f - u * u * (3.0f - 2.0f * u);
}

// Share of the probit-threshold model that a filtered level set covers: a smoother step whose middle follows the normal
// distribution function within 0.018 and whose tails end, so that empty is empty. level and spread in the same unit.
SHARED_CONST float kShareReach = 2.6f;  // standard deviations at which it ends
SHARED_FN float share_above(float level, float spread) {
  float u = clamp(0.5f + level / (2.0f * kShareReach * spread), 0.0f, 1.0f);
  return u * u * u * (u * (u * 6.0f - 15.0f) + 10.0f);
}

// Mean of max(level, 0) over that distribution: the integral of share_above, in closed form.
SHARED_FN float mean_above(float level, float spread) {
  float x = level / spread;
  float u = clamp(0.5f + x / (2.0f * kShareReach), 0.0f, 1.0f);
  float inside = 2.0f * kShareReach * u * u * u * u * (u * (u - 3.0f) + 2.5f);
  return spread * (inside + max(x - kShareReach, 0.0f));
}

// Mean of clamp(level / width, 0, 1): density where details of the level below `spread` are unresolved.
SHARED_FN float mean_ramp(float level, float width, float spread) {
  return (mean_above(level, spread) - mean_above(level - width, spread)) / width;
}

// Extinction of a medium in which blobs of `size_m` and extinction `sigma_per_m` fill the share `share` at random: what
// gives the mean transmittance of one blob length. share * sigma when blobs are thin, -log(1 - share) / size when opaque.
SHARED_FN float clumped_extinction(float share, float sigma_per_m, float size_m) {
  float filled = share * (1.0f - exp(-sigma_per_m * size_m));
  return -log(max(1.0f - filled, 1.0e-6f)) / size_m;
}

// What a cell must exceed at relative height eta (0 the base, 1 the top), standard deviations. The outline is Haggstrom's
// shape-altering parabola 1 - (2 eta^bias - 1)^2 read as a share of the widest place: 0 there, growing without bound
// towards the top. relief scales it; an anvil takes the top fifth back out beyond the tower.
SHARED_CONST float kAnvilWidth = 0.35f;  // standard deviations that a full anvil spreads beyond the widest place
// Share of the anvil at eta: 0 in the tower, 1 in the top fifth of a full anvil.
SHARED_FN float anvil_share(float eta, float anvil) { return anvil * smoothstep(0.70f, 0.82f, eta); }
SHARED_FN float excess_needed(float eta, float bias, float relief, float anvil) {
  float e = clamp(eta, 1.0e-4f, 0.9999f);
  float t = exp2(bias * log2(e));
  float open = max(4.0f * t * (1.0f - t), 1.0e-5f);
  float need = -relief * log(open);
  float out_there = anvil_share(e, anvil);
  float close = -0.35f * log(max(1.0f - smoothstep(0.86f, 1.0f, e), 1.0e-5f));
  need = mix(need, close - kAnvilWidth, out_there);
  float under = max(0.02f - eta, 0.0f);  // nothing below the base, and its last metres cut sharply
  return need + 40.0f * under;
}

// The level that the horizontal field must beat at eta under local coverage `probit`: like need - probit for a broken
// sky; where the sky is nearly covered tops keep their relief instead of all touching the layer's top.
SHARED_CONST float kProbitRelief = 0.5f;  // coverage beyond this probit closes gaps but raises no tops
SHARED_CONST float kDeckSlope = 0.3f;
SHARED_FN float cell_threshold(float need, float probit) {
  return min(need - min(probit, kProbitRelief), max(need, need / kDeckSlope) - probit);
}

SHARED_FN float density_profile(vec4 abcd, float eta) { return max(abcd.x * exp(abcd.y * eta) + abcd.z * eta + abcd.w, 0.0f); }

SHARED_END
#endif
