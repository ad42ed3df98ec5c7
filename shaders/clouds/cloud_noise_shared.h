// Layout of the generator of the clouds' noise volumes (docs/cloud_noise.md).
#ifndef NEPHO_CLOUD_NOISE_SHARED_H
#define NEPHO_CLOUD_NOISE_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// What cloud_noise.comp makes; its specialisation constant 0.
SHARED_CONST uint kNoiseField = 0u;       // rgba: four fractal fields
SHARED_CONST uint kNoiseCells = 1u;       // r: rounded cells, g: a finer fractal
SHARED_CONST uint kNoiseShape = 2u;       // r: billows
SHARED_CONST uint kNoiseDetail = 3u;      // r: small billows
SHARED_CONST uint kNoiseTurbulence = 4u;  // rgb: a vector potential, whose curl is the turbulence

struct CloudNoisePush {
  uint size;  // texels a side
  uint seed;
};

SHARED_END
#endif
