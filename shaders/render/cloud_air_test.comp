#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: luminance of the air between the camera and a distance, per pixel.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
struct Place { vec2 pixel; float distance_m; };
layout(scalar, set = 0, binding = 1) readonly buffer PlaceBlock { Place at[]; } places;
layout(scalar, set = 0, binding = 2) writeonly buffer AirBlock { vec3 at[]; } airs;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= places.at.length()) return;
  FrameConstants f = frame.frame_data;
  vec3 through;
  airs.at[i] = aerial_perspective(f, pixel_direction(f, places.at[i].pixel), places.at[i].distance_m, 0.0, through);
}
