// Data and pure functions of the cloud model, for C++ and GLSL (docs/clouds.md uses these names).
#ifndef NEPHO_CLOUDS_SHARED_H
#define NEPHO_CLOUDS_SHARED_H
#include "common/phase.h"
#include "weather/weather_shared.h"
SHARED_BEGIN

SHARED_CONST uint kCloudNoiseField = 0u;   // rg: fractal field, cells
SHARED_CONST uint kCloudNoiseShape = 1u;   // billows
SHARED_CONST uint kCloudNoiseDetail = 2u;  // small billows

struct CloudNoisePush {
  uint kind;
  uint size;  // texels a side
  uint seed;
};

// A square of vertical columns (cloud_columns.comp).
struct CloudColumnsPush {
  vec3 east, north;   // unit, ECEF axes, at the camera
  float side_m;       // of the square
  float footprint_m;  // detail smaller than this is averaged
  uint count;         // columns along a side
  uint steps;         // samples of a column
};

// Where one noise is read: its lattice turned and scaled against camera-relative ECEF metres.
SHARED_CONST uint kDomainRegional = 0u;  // field.r, 60..8 km
SHARED_CONST uint kDomainMeso = 1u;      // field.r, 15..2 km
SHARED_CONST uint kDomainCell = 2u;      // field.g, 2.7..1.3 km
SHARED_CONST uint kDomainShape = 3u;     // shape, 800..180 m
SHARED_CONST uint kDomainDetail = 4u;    // detail, 130..60 m
SHARED_CONST uint kDomainFine = 5u;      // detail, 36..18 m
SHARED_CONST uint kDomainWarp = 6u;      // field.rg, 280..35 km: bends the regional lattice, so that no period shows
SHARED_CONST uint kCloudDomains = 7u;

struct CloudDomain {
  mat3 uvw_from_cam;   // 1/m; rotation and scale
  vec3 offset;         // the camera's own coordinate, reduced modulo 1 in double
  float log2_texel_m;  // log2 of a texel's size
};

struct CloudConstants {
  CloudDomain domains[7];
  mat3 weather_from_ecef;     // turn of the weather map by the wind, scaled axes
  float base_m;               // geodetic height of the layer's base, m
  float thickness_m;          // m
  float extinction_per_m;     // at density 1
  float coverage;             // 0 draws nothing
  float shape_amount;         // 0..1
  float detail_amount;        // 0..1
  float log2_weather_texel_m;
  float phase_g_forward;
  float phase_g_backward;
  float phase_backward_weight;
  float ground_albedo;        // of what lies below, for light from under the clouds
  float uniform_density;      // > 0: the layer is a slab of this density (a test of the march)
  vec4 fade_start;            // variance_left() of field.r, field.g, shape, detail
  vec4 fade_per_lod;
};

// Variance that a noise keeps at a level of detail, as a smooth step down from `start`; fitted to its mips (cloud_noise.cpp).
SHARED_FN float variance_left(float lod, float start, float per_lod) {
  float u = clamp((lod - start) * per_lod, 0.0f, 1.0f);
  return 1.0f - u * u * (3.0f - 2.0f * u);
}

// Share of the probit-threshold model that a filtered level set covers: a smoother step whose middle follows the normal
// distribution function within 0.018 and whose tails end, so that empty is empty. level and spread in the same unit.
SHARED_FN float share_above(float level, float spread) {
  float u = clamp(0.5f + level / (5.2f * spread), 0.0f, 1.0f);
  return u * u * u * (u * (u * 6.0f - 15.0f) + 10.0f);
}

// Extinction of a medium in which blobs of `size_m` and extinction `sigma_per_m` fill the share `share` at random: what
// gives the mean transmittance of one blob length. share * sigma when blobs are thin, -log(1 - share) / size when opaque.
SHARED_FN float clumped_extinction(float share, float sigma_per_m, float size_m) {
  float filled = share * (1.0f - exp(-sigma_per_m * size_m));
  return -log(max(1.0f - filled, 1.0e-6f)) / size_m;
}

// What a cell must exceed, in standard deviations of the horizontal field, to reach the relative height eta (0 the base,
// 1 the layer's top): 0 where the cell is widest, rising towards the top without bound, and steeply below the base.
SHARED_CONST float kCellHeight = 1.15f;  // excess at which a cell fills 63 % of the layer
SHARED_CONST float kCellWaist = 0.16f;   // eta of the widest part
SHARED_CONST float kBaseSharpness = 26.0f;
SHARED_FN float excess_needed(float eta) {
  float above = min(max(eta - kCellWaist, 0.0f) / (1.0f - kCellWaist), 0.9999f);
  float below = max(kCellWaist - eta, 0.0f) / kCellWaist;
  float under = max(0.05f - eta, 0.0f);
  return -kCellHeight * log(1.0f - above) + 0.22f * below * below + kBaseSharpness * under;
}

// The level that the horizontal field must beat at eta under local coverage `probit`: like excess_needed(eta) - probit
// for a broken sky; where the sky is nearly covered tops keep their relief instead of all touching the layer's top.
SHARED_CONST float kProbitRelief = 0.5f;  // coverage beyond this probit closes gaps but raises no tops
SHARED_CONST float kDeckSlope = 0.3f;
SHARED_FN float cell_threshold(float eta, float probit) {
  float need = excess_needed(eta);
  return min(need - min(probit, kProbitRelief), need / kDeckSlope - probit);
}

// Probit of the threshold under which the whole model (cells, shape, detail, an optical depth above 1) covers
// the share of the sky whose probit is asked. Fitted to columns of the model itself (docs/clouds.md, 'Coverage').
SHARED_CONST float kCoverScale = 1.06f;
SHARED_CONST float kCoverShift = -0.09f;
SHARED_FN float threshold_probit(float probit) { return kCoverScale * probit + kCoverShift; }

SHARED_END
#endif
