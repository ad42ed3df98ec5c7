#pragma once
#include <vector>

#include "scene/scene_fields.h"

namespace nepho {

/// The parameters of one entry, and of a whole stack as the list `field.name`, in which a plain string is a path.
void describe(FieldVisitor& v, ElevationSource& p);
void describe(FieldVisitor& v, ImagerySource& p);
void describe_stack(FieldVisitor& v, const Field& field, std::vector<ElevationSource>& stack);
void describe_stack(FieldVisitor& v, const Field& field, std::vector<ImagerySource>& stack);

}  // namespace nepho
