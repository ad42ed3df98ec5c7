// The global weather map: layout of its generator and the closed forms of its coverage (docs/clouds.md, 'Coverage').
#ifndef NEPHO_WEATHER_SHARED_H
#define NEPHO_WEATHER_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kWeatherVortices = 28u;

struct WeatherGenerate {
  vec4 vortices[28];  // xyz: unit centre on the sphere, w: turn at the centre, rad (sign: sense of rotation)
  vec4 vortex_size;   // x: e-folding radius in rad of vortex 0, y: added per vortex index
  uint size;          // texels along a face
  uint seed;
};

// Unit direction (scaled ECEF axes) of a cube face's point; u, v in -1..1. The faces and their axes are Vulkan's.
SHARED_FN vec3 cube_direction(uint face, float u, float v) {
  vec3 d = vec3(1.0f, -v, -u);
  if (face == 1u) d = vec3(-1.0f, -v, u);
  if (face == 2u) d = vec3(u, 1.0f, v);
  if (face == 3u) d = vec3(u, -1.0f, -v);
  if (face == 4u) d = vec3(u, -v, 1.0f);
  if (face == 5u) d = vec3(-u, -v, -1.0f);
  return normalize(d);
}

// The standard normal's distribution function by the logistic approximation, error below 0.0095 (Bowling 2009 has a
// closer one; this inverts in closed form).
SHARED_FN float share_from_probit(float z) { return 1.0f / (1.0f + exp(-1.702f * z)); }

// Its inverse; 0 and 1 become -8 and 8, beyond everything the noise reaches.
SHARED_FN float probit_from_share(float share) {
  if (share <= 0.0005f) return -8.0f;
  if (share >= 0.9995f) return 8.0f;
  return log(share / (1.0f - share)) / 1.702f;
}

SHARED_END
#endif
