#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "compare/plane.h"

namespace nepho {

/// Where the eye of FLIP is: by default 0.7 m from a display 0.7 m and 3840 pixels wide, 67 pixels a degree.
struct FlipView {
  double distance_m = 0.7;
  double width_m = 0.7;
  double width_px = 3840.0;
  double pixels_per_degree() const;
};

/// The difference that a person sees when flipping between two pictures, 0..1 for each pixel: LDR-FLIP of Andersson et
/// al. 2020, 'FLIP: A Difference Evaluator for Alternating Images', with the constants of the authors' own program.
/// The pictures are sRGB encoded, 0..1, row by row. Symmetric in its two pictures.
Plane flip_map(uint32_t width, uint32_t height, std::span<const glm::vec3> test, std::span<const glm::vec3> reference,
               const FlipView& view = {});

}  // namespace nepho
