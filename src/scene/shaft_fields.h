#pragma once
#include "scene/scene_fields.h"

namespace nepho {

/// The description of the parameters of light shafts and of haze, for visit_fields().
void describe(FieldVisitor& visitor, ShaftParams& params);
void describe(FieldVisitor& visitor, HazeParams& params);

}  // namespace nepho
