#ifndef NEPHO_RENDER_SHARED_H
#define NEPHO_RENDER_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kHistogramBins = 256u;
SHARED_CONST float kHistogramMinLog2 = -24.0f;     // log2 cd/m2: 6e-8, far below the ground under a moonless sky (1e-6)
SHARED_CONST float kHistogramMaxLog2 = 31.0f;
SHARED_CONST float kMeterMaxLuminance = 2.0e6f;    // cd/m2: brighter pixels, the sun's disc, are not metered

// The meter looks at about 60,000 pixels, on a regular grid: every so many in both directions. More do not change it.
SHARED_FN uint meter_stride(uint width, uint height) {
  return max(1u, uint(sqrt(float(width) * float(height) / 60000.0f) + 0.5f));
}

// Black space does not count, nor does the sun's disc: no surface in its light is as bright.
SHARED_FN bool meter_counts(float luminance_cd_m2) {
  return luminance_cd_m2 > exp2(kHistogramMinLog2) && luminance_cd_m2 < kMeterMaxLuminance;
}

// Bin of a luminance that counts.
SHARED_FN uint meter_bin(float luminance_cd_m2) {
  float x = (log2(luminance_cd_m2) - kHistogramMinLog2) / (kHistogramMaxLog2 - kHistogramMinLog2);
  return uint(clamp(x, 0.0f, 0.999999f) * float(kHistogramBins));
}

struct BackgroundPush {
  float wind_mps;               // over water, for its roughness
  float night_light_cd_m2;      // luminance of city lights where the night picture is white
  uint has_cloud_shadow;        // 1: sun_visibility holds the clouds' transmittance towards the key light
  float ground_albedo;          // mean albedo around, for light from below
  uvec2 light_nodes;            // of cloud_light; 0: light falls on the ground as under a clear sky
};

struct DiscsPush {
  ivec2 first;                  // pixels that may show a disc
  ivec2 last;                   // and the end of them
};

struct ExposurePush {
  uvec2 size;
  uint stride;                  // of the metered pixels
  uint automatic;
  float fixed_ev100;            // used when automatic == 0
  float min_ev100;
  float max_ev100;
  float compensation_ev;        // brighter by this many stops
  float keep_share;             // 0..1: of the last frame's EV100; 0 jumps to the metered value
};

struct TonemapPush {
  uvec2 size;
  uint dither_offset;           // shifts the pattern of the dither
  mat3 white_balance;           // linear Rec. 709 to itself: the chosen daylight becomes white
};

struct ExposureState {
  float ev100;
  float exposure;               // 1 / (cd/m2)
};

SHARED_END
#endif
