#pragma once
#include "atmosphere/atmosphere_shared.h"
#include "scene/atmosphere_params.h"

namespace nepho {

/// What shaders know of the air. Throws Error(usage) that names the parameter when one makes no sense (a scale height
/// of 0, a NaN, scattering above extinction).
shared::AtmosphereUniform make_atmosphere_uniform(const AtmosphereParams& params);

}  // namespace nepho
