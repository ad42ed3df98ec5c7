#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: the ground map in given directions (two vec4 each: albedo and water; height, and height alone).
#include "common/shared.h"
#define GROUND_MAP_BINDING 0
#include "terrain/ground_map.glsl"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 2) uniform Map { RegionMap map; } region;
layout(scalar, set = 0, binding = 3) readonly buffer Directions { vec4 at[]; } directions;
layout(scalar, set = 0, binding = 4) writeonly buffer Values { vec4 at[]; } values;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= directions.at.length()) return;
  vec3 dir = directions.at[i].xyz;
  GroundPoint g = ground_at(region.map, dir);
  values.at[2u * i] = vec4(g.albedo, g.water);
  values.at[2u * i + 1u] = vec4(g.height_m, ground_height_m(region.map, dir), 0.0, 0.0);
}
