#pragma once
#include "scene/scene_fields.h"
#include "scene/shadow_params.h"

namespace nepho {

/// The parameters of clouds.shadows.
void describe(FieldVisitor& v, CloudShadowParams& p);

}  // namespace nepho
