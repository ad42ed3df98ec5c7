#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: the share of the key light that terrain leaves at given camera-relative points of the air, by the map of shadow heights.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define TERRAIN_VOLUME_BINDING 1
#include "terrain/terrain_volume.glsl"
layout(scalar, set = 0, binding = 3) readonly buffer Points { vec4 at[]; } points;
layout(scalar, set = 0, binding = 4) writeonly buffer Shares { float at[]; } shares;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < points.at.length()) shares.at[i] = terrain_volume_share(points.at[i].xyz);
}
