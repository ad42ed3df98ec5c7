#version 460
#extension GL_GOOGLE_include_directive : require
// Empties the star image before star_splat.comp.
#include "render/night_sky_shared.h"

layout(local_size_x = 256) in;
layout(set = 0, binding = 0, scalar) writeonly buffer StarPixelBlock { uint values[]; } star_pixels;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < uint(star_pixels.values.length())) star_pixels.values[i] = 0u;
}
