#ifndef NEPHO_RENDER_SHARED_H
#define NEPHO_RENDER_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kHistogramBins = 256u;
SHARED_CONST float kHistogramMinLog2 = -24.0f;  // log2 cd/m2
SHARED_CONST float kHistogramMaxLog2 = 31.0f;

struct BackgroundPush {
  float wind_mps;               // over water, for its roughness
  float night_light_cd_m2;      // luminance of city lights where the night picture is white
  uint has_cloud_shadow;        // 1: sun_visibility holds the clouds' transmittance towards the sun
  float ground_albedo;          // mean albedo around, for light from below
};

struct ExposurePush {
  uvec2 size;
  float fixed_ev100;            // used when automatic == 0
  uint automatic;
  float min_ev100;
  float max_ev100;
};

struct TonemapPush {
  uvec2 size;
  uint curve;                   // kTone... of common/tonemap.h
  uint seed;                    // of the dither
  mat3 white_balance;           // linear Rec. 709 to itself: the chosen daylight becomes white
};

struct ExposureState {
  float ev100;
  float exposure;               // 1 / (cd/m2)
};

SHARED_END
#endif
