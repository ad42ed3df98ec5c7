// The octave approximation of multiple scattering that other renderers use, for comparison (docs/accuracy.md).
#ifndef NEPHO_CLOUDS_OCTAVES_H
#define NEPHO_CLOUDS_OCTAVES_H
#include "common/phase.h"
SHARED_BEGIN

SHARED_CONST int kOctaveSumTerms = 8;
SHARED_CONST float kOctaveSumFactor = 0.5f;  // of attenuation, contribution and asymmetry from one octave to the next

// Sunlight that a point scatters towards the eye, per unit of irradiance and of scattering coefficient, 1/sr: single
// scattering, and for the orders beyond it copies of it with less attenuation, contribution and asymmetry:
//   sum over n = 0..7 of b^n p(cos_theta; c^n g, c^n alpha) exp(-a^n sun_depth),   a = b = c = 0.5
// Only the sun's path is scaled, not the eye's. Wrenninge, Kulla, Lundqvist 2013 (Oz: The Great and Volumetric). The copies
// count `more` times; 1 is theirs.
SHARED_FN float octave_sum(float cos_theta, PhaseLobes phase, float more, float sun_depth) {
  float sum = 0.0f, factor = 1.0f;
  for (int n = 0; n < kOctaveSumTerms; ++n) {
    PhaseLobes wider = phase_wider(phase, factor);
    sum += (n == 0 ? 1.0f : more) * factor * phase_lobes(wider, cos_theta) * exp(-factor * sun_depth);
    factor *= kOctaveSumFactor;
  }
  return sum;
}

SHARED_END
#endif
