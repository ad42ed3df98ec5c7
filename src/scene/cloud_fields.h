#pragma once
#include "scene/scene_fields.h"

namespace nepho {

/// The description of the parameters of the clouds, for visit_fields().
void describe(FieldVisitor& visitor, CloudParams& params);

}  // namespace nepho
