// An artist's option that no physics asks for (docs/light.md, 'Artist's options').
#ifndef NEPHO_CLOUDS_POWDER_H
#define NEPHO_CLOUDS_POWDER_H
#include "common/shared.h"
SHARED_BEGIN

// Factor of the key light that clouds scatter to the eye from an optical depth to the light: Schneider's Beer-powder (2015, The
// Real-time Volumetric Cloudscapes of Horizon: Zero Dawn) is exp(-d) times 2 (1 - exp(-2 d)). In full with the light behind
// the camera, nothing looking into it: cos_theta is between view ray and light. 1 where strength is 0.
SHARED_FN float powder_factor(float sun_depth, float cos_theta, float strength) {
  return mix(1.0f, 2.0f * (1.0f - exp(-2.0f * sun_depth)), strength * 0.5f * (1.0f - cos_theta));
}

SHARED_END
#endif
