// False colours of debug views (docs/debug_views.md).
#ifndef NEPHO_DEBUG_SHARED_H
#define NEPHO_DEBUG_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kDebugWeather = 0u;
SHARED_CONST uint kDebugDensity = 1u;
SHARED_CONST uint kDebugLayers = 2u;
SHARED_CONST uint kDebugSamples = 3u;
SHARED_CONST uint kDebugSteps = 4u;
SHARED_CONST uint kDebugShadows = 5u;

// Turbo (Mikhailov 2019), polynomial fit, 0..1: dark blue, cyan, green, yellow, dark red. sRGB values.
SHARED_FN vec3 turbo(float x) {
  float t = clamp(x, 0.0f, 1.0f);
  float r = 0.13572138f + t * (4.61539260f + t * (-42.66032258f + t * (132.13108234f + t * (-152.94239396f + t * 59.28637943f))));
  float g = 0.09140261f + t * (2.19418839f + t * (4.84296658f + t * (-14.18503333f + t * (4.27729857f + t * 2.82956604f))));
  float b = 0.10667330f + t * (12.64194608f + t * (-60.58204836f + t * (110.36276771f + t * (-89.90310912f + t * 27.34824973f))));
  return clamp(vec3(r, g, b), vec3(0.0f), vec3(1.0f));
}

// Colour of layer 0..3 (Okabe and Ito's set, told apart by colour-blind eyes).
SHARED_FN vec3 layer_color(uint layer) {
  if (layer == 0u) return vec3(0.90f, 0.62f, 0.0f);
  if (layer == 1u) return vec3(0.34f, 0.71f, 0.91f);
  if (layer == 2u) return vec3(0.0f, 0.62f, 0.45f);
  return vec3(0.80f, 0.47f, 0.65f);
}

// 0..1 of an optical depth: 0.01 to 100, a factor of 10 every quarter.
SHARED_FN float depth_shade(float depth) { return 0.25f * (log(max(depth, 1.0e-6f)) / log(10.0f) + 2.0f); }

SHARED_END
#endif
