#version 460
#extension GL_GOOGLE_include_directive : require
// The largest extinction around each 2 x 2 x 2 voxels of the density grid: axis 0 reduces voxels and spreads along x, 1 and 2
// spread along y and z, each by kMostReach cells.
#include "clouds/light_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform LightBlock { CloudLightConstants data; } light;
layout(set = 0, binding = 1) uniform sampler3D in_tex;
layout(set = 0, binding = 2, r16f) uniform writeonly image3D out_most;
layout(constant_id = 0) const uint AXIS = 0u;

float most_of(ivec3 cell) {
  if (AXIS != 0u) return texelFetch(in_tex, cell, 0).r;
  float most = 0.0;
  for (int k = 0; k < 8; ++k) most = max(most, texelFetch(in_tex, 2 * cell + ivec3(k & 1, (k >> 1) & 1, k >> 2), 0).r);
  return most * 1.001;  // half floats round
}

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  ivec3 size = imageSize(out_most);
  if (any(greaterThanEqual(at, size))) return;
  int depth = int(light.data.grid.slices) / 2, level = at.z / depth;
  ivec3 low = ivec3(0, 0, level * depth), high = ivec3(size.xy - 1, level * depth + depth - 1);
  ivec3 along = ivec3(AXIS == 0u ? 1 : 0, AXIS == 1u ? 1 : 0, AXIS == 2u ? 1 : 0);
  float most = 0.0;
  for (int i = -int(kMostReach); i <= int(kMostReach); ++i) most = max(most, most_of(clamp(at + i * along, low, high)));
  imageStore(out_most, at, vec4(most));
}
