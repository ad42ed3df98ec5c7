#pragma once
#include <glm/mat3x3.hpp>

namespace nepho {

/// Linear Rec. 709 to linear Rec. 709 that shows CIE daylight of this colour temperature (K, 4000..25000) as white, by
/// Bradford's chromatic adaptation: what a camera's white balance does. 6504 K is the identity.
glm::dmat3 rec709_white_balance(double daylight_k);

}  // namespace nepho
