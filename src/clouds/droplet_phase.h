#pragma once
#include <array>
#include <cstddef>

#include "common/phase.h"
#include "scene/cloud_params.h"

namespace nepho {

/// A phase function of cloud droplets: two of Draine's lobes (docs/light.md, 'Phase functions').
struct DropletPhase {
  struct Lobe {
    double g = 0.0;       ///< of its Henyey-Greenstein part, (-1, 1)
    double alpha = 0.0;   ///< 0: Henyey-Greenstein, 1: Cornette-Shanks; >= 0
    double weight = 0.0;  ///< share of scattering
  };
  std::array<Lobe, 2> lobes;  ///< the narrower, forward one first

  /// 1/sr, over the cosine of the angle between directions of travel.
  double operator()(double cosine) const;
  /// Legendre moment, the mean of P_l(cosine), in closed form: 1 for l = 0, the mean cosine for l = 1.
  double moment(size_t l) const;
  /// The same for shaders.
  shared::PhaseLobes constants() const;
};

/// The phase function that `clouds.phase` and its fields name.
DropletPhase droplet_phase(const CloudParams& params);

/// A fit to Lorenz-Mie's phase function of water droplets in fog and clouds, 95 % of its light, without glory and bows:
/// Jendersie and d'Eon 2023, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", equations 4 to 7.
/// `diameter_um`: droplets' diameter, 5..50 micrometres.
DropletPhase mie_fit(double diameter_um);

}  // namespace nepho
