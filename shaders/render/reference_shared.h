// Sums of the path tracer's pictures, for C++ and GLSL (docs/reference.md).
#ifndef NEPHO_RENDER_REFERENCE_SHARED_H
#define NEPHO_RENDER_REFERENCE_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// Means over a pixel's paths so far, and sums of squared differences from them (Welford 1962).
struct PixelSums {
  float paths;
  vec3 mean;            // luminance per channel, cd/m2
  vec3 squares;
  float y_squares;      // of the luminance Y
  vec3 cloud;           // mean of what came by a cloud first, with its air
  float transmittance;  // mean of what passed the clouds
  float depth_m;        // sum over the paths that met a cloud first of the distance to it
  vec4 layers;          // number of paths that met each layer first
};

struct ReferencePush {
  uint pixels, seed, width, subpixels;
  float furnace_cd_m2;
  float night_light_cd_m2;
};

SHARED_END
#endif
