#pragma once
#include <cstdint>
#include <vector>

#include "clouds/cloud_noise_shared.h"

namespace nepho {

/// Octaves of one kind of noise: the first has `cycles` a side and the weight `amplitude`, each further one twice the
/// cycles and `gain` times the weight.
struct NoiseOctaves {
  int cycles = 4;
  int count = 1;
  float gain = 0.5f;
  float amplitude = 1.0f;
  bool domes = false;  ///< 1 - d^2 of Worley 1996, instead of the gradient noise of Perlin 2002
  float bend = 0.0f;   ///< domes: how far their places are moved, in sides of the volume
};

/// One channel of a volume: the octaves that cloud_noise.comp adds up.
using NoiseRecipe = std::vector<NoiseOctaves>;

/// One octave as the shader takes it.
struct NoiseDispatch {
  bool dome = false;
  shared::NoiseTerm term;
};

/// A recipe for a volume of `size` texels a side. Every seed gives every octave another lattice, turned and shifted its
/// own way: gradient noise is 0 at its lattice points, and rows show where those of several octaves meet.
std::vector<NoiseDispatch> noise_dispatches(const NoiseRecipe& recipe, uint32_t size, uint32_t seed);

}  // namespace nepho
