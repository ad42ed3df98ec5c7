#version 460
#extension GL_GOOGLE_include_directive : require
// The marked cells as a list.
#include "clouds/light_shared.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform LightBlock { CloudLightConstants data; } light;
layout(scalar, set = 0, binding = 1) readonly buffer MarkBlock { uint at[]; } marks;
layout(scalar, set = 0, binding = 2) buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 3) writeonly buffer ListBlock { uint at[]; } list;
void main() {
  uint word = gl_GlobalInvocationID.x;
  LightCells cells = light.data.cells;
  if (word >= cells.nodes.x * cells.nodes.y * (cells.slices / 32u)) return;
  uint bits = marks.at[word];
  if (bits == 0u) return;
  uint at = atomicAdd(work.data.count, uint(bitCount(bits)));
  while (bits != 0u) {
    list.at[at++] = word * 32u + uint(findLSB(bits));
    bits &= bits - 1u;
  }
}
