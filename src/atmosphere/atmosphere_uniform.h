#pragma once
#include "atmosphere/atmosphere_shared.h"
#include "scene/atmosphere_params.h"

namespace nepho {

/// What shaders know of the air, and the number of groups of its spectrum that are in use.
struct AtmosphereConstants {
  shared::AtmosphereData data;
  int spectral_groups = 1;
};

/// Throws Error(usage) that names the parameter when one makes no sense (a scale height of 0, a NaN, scattering above
/// extinction).
AtmosphereConstants make_atmosphere_constants(const AtmosphereParams& params);

/// Groups of three wavelengths for a value of AtmosphereParams::spectral: the specialisation constant of every shader
/// that includes atmosphere_lookup.glsl.
int spectral_groups(const AtmosphereParams& params);

}  // namespace nepho
