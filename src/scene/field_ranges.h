#pragma once
#include "scene/scene_fields.h"

namespace nepho {

// Short ways to say a range, for the tables of parameters.
inline Range closed(double min, double max) { return {.min = min, .max = max}; }
inline Range open(double min, double max) { return {.min = min, .max = max, .min_open = true, .max_open = true}; }
inline Range share() { return closed(0.0, 1.0); }

}  // namespace nepho
