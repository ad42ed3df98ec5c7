// Phase functions, 1/sr; each integrates to 1 over the sphere. cos_theta is between the directions of travel before and
// after the event (1: forward).
#ifndef NEPHO_COMMON_PHASE_H
#define NEPHO_COMMON_PHASE_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_FN float phase_isotropic() { return 1.0f / (4.0f * kPi); }

// Rayleigh: 3 / (16 pi) (1 + cos^2).
SHARED_FN float phase_rayleigh(float cos_theta) { return 3.0f / (16.0f * kPi) * (1.0f + cos_theta * cos_theta); }

// Henyey-Greenstein 1941.
SHARED_FN float phase_hg(float cos_theta, float g) {
  float d = max(1.0f + g * g - 2.0f * g * cos_theta, 1.0e-7f);
  return (1.0f - g * g) / (4.0f * kPi * d * sqrt(d));
}

// Cornette-Shanks 1992, as Bruneton 2017 uses it for aerosol.
SHARED_FN float phase_cornette_shanks(float cos_theta, float g) {
  float d = max(1.0f + g * g - 2.0f * g * cos_theta, 1.0e-7f);
  return 3.0f / (8.0f * kPi) * (1.0f - g * g) / (2.0f + g * g) * (1.0f + cos_theta * cos_theta) / (d * sqrt(d));
}

// Two Henyey-Greenstein lobes: weight w of the second.
SHARED_FN float phase_dual_hg(float cos_theta, float g0, float g1, float w) {
  return mix(phase_hg(cos_theta, g0), phase_hg(cos_theta, g1), w);
}

SHARED_END
#endif
