#version 460
#extension GL_GOOGLE_include_directive : require
// Writes how far the emptiness around empty slices reaches, one column of one level each invocation (CloudBounds).
#include "clouds/path_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform BoundsBlock { CloudBounds data; } bounds;
layout(set = 0, binding = 1, r32f) uniform image3D out_bounds;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, ivec2(kBoundsTexels)))) return;
  for (uint b = 0u; b < bounds.data.bands; ++b) {
    int slices = int(bounds.data.band_slices[b]), first = at.z * int(kBoundsSlices) + int(bounds.data.band_first[b]);
    int start = 0;  // of the run at hand
    for (int i = 0; i <= slices; ++i) {
      bool empty = i < slices && imageLoad(out_bounds, ivec3(at.xy, first + i)).r <= 0.0;
      if (empty) continue;
      for (int j = start; j < i; ++j)
        imageStore(out_bounds, ivec3(at.xy, first + j), vec4(-(1.0 + float(j - start) + kBoundsRun * float(i - 1 - j))));
      start = i + 1;
    }
  }
}
