#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: what the sampler makes of a cube image in given directions; w is the level of detail.
#include "common/shared.h"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform samplerCube cube_tex;
layout(scalar, set = 0, binding = 1) readonly buffer Directions { vec4 at[]; } directions;
layout(scalar, set = 0, binding = 2) writeonly buffer Values { vec4 at[]; } values;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= directions.at.length()) return;
  values.at[i] = textureLod(cube_tex, directions.at[i].xyz, directions.at[i].w);
}
