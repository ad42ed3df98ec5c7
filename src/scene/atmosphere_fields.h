#pragma once
#include "scene/scene_fields.h"

namespace nepho {

/// The description of the parameters of the air and of the night sky, for visit_fields().
void describe(FieldVisitor& visitor, AtmosphereParams& params);
void describe(FieldVisitor& visitor, NightSkyParams& params);

}  // namespace nepho
