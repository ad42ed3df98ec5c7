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

// Draine 2003: Henyey-Greenstein times 1 + alpha cos^2. alpha 0 is Henyey-Greenstein (to the bit), alpha 1 Cornette-Shanks.
SHARED_FN float phase_draine(float cos_theta, float g, float alpha) {
  return phase_hg(cos_theta, g) * (1.0f + alpha * cos_theta * cos_theta) / (1.0f + alpha * (1.0f + 2.0f * g * g) / 3.0f);
}

// Two lobes: `weight` is the share of the second. What cloud droplets have (docs/light.md, 'Phase functions').
struct PhaseLobes {
  float g0;
  float alpha0;
  float g1;
  float alpha1;
  float weight;
};

// The same with less asymmetry: factor 0 is isotropic.
SHARED_FN PhaseLobes phase_wider(PhaseLobes p, float factor) {
  p.g0 *= factor;
  p.alpha0 *= factor;
  p.g1 *= factor;
  p.alpha1 *= factor;
  return p;
}

SHARED_FN float phase_lobes(PhaseLobes p, float cos_theta) {
  return mix(phase_draine(cos_theta, p.g0, p.alpha0), phase_draine(cos_theta, p.g1, p.alpha1), p.weight);
}

SHARED_END
#endif
