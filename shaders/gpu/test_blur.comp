#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/shared.h"
// Sums the eight texels of a row into a buffer.
layout(local_size_x = 4) in;
layout(set = 0, binding = 0) uniform sampler2D source;
layout(set = 0, binding = 1, scalar) buffer SumsBlock { float values[]; } sums;
void main() {
  uint y = gl_GlobalInvocationID.x;
  if (y >= uint(textureSize(source, 0).y)) return;
  float sum = 0.0;
  for (int x = 0; x < textureSize(source, 0).x; ++x) sum += texelFetch(source, ivec2(x, y), 0).r;
  sums.values[y] = sum;
}
