// The global weather map: layout of its generator, and closed forms of coverage (docs/weather.md).
#ifndef NEPHO_WEATHER_SHARED_H
#define NEPHO_WEATHER_SHARED_H
#include "common/cube_sphere.h"
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kWeatherVortices = 48u;
SHARED_CONST uint kWeatherDecks = 6u;

struct WeatherVortex {
  vec3 centre;    // unit, scaled axes
  float turn;     // of the air at the centre during the time of the trace, rad; > 0 counter-clockwise
  float radius;   // where the turn is half of that, rad
  float tropical; // 1 for tropical cyclones, 0 for others
};

struct WeatherGenerate {
  WeatherVortex vortices[48];
  vec4 decks[6];  // stratocumulus: xyz unit centre, w: half width in latitude, rad
  uint size;      // texels along a face
  uint seed;
};

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
