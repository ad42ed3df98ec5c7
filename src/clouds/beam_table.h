#pragma once
#include <cstddef>
#include <vector>

#include "clouds/droplet_phase.h"

namespace nepho {

/// A phase function of cloud droplets, cut for transport (docs/light.md, 'The scaled medium'): a share f of scattering
/// goes nearly straight on, the rest is wide, such that the first two moments stay (delta-M, Wiscombe 1977).
struct PhaseCut {
  double forward_share = 0.0;  ///< f
  double wide_g = 0.0;         ///< asymmetry of the rest, drawn from Henyey and Greenstein's function
};

/// From the moments <P_1> and <P_2> of the function, 1 - f > 0.
PhaseCut cut_phase(double p1, double p2);

/// For every angle theta = pi (i / (texels - 1))^2 between a view ray and the light, and every order k = 0..orders - 1:
/// the phase function of light that went k times nearly straight on before it is scattered to the eye, 1/sr. Row-major:
/// rows of four orders each, RGBA. Order 0 is the function itself; the others are multiplied by `more`.
std::vector<float> beam_table(const DropletPhase& phase, const PhaseCut& cut, size_t texels, size_t orders,
                              double more = 1.0);

}  // namespace nepho
