#version 460
#extension GL_GOOGLE_include_directive : require
// Adds one octave to one channel of a tileable noise volume, raw; cloud_noise.cpp gives the sum its distribution and
// mips (docs/cloud_noise.md). One dispatch an octave: its lattice then sits in push constants, which software devices
// read a hundred times as fast as a list in a buffer.
#include "clouds/cloud_noise_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const bool kDome = false;  // Worley's domes instead of gradient noise
layout(push_constant, scalar) uniform Push { NoiseTerm push; };
layout(set = 0, binding = 0, r32f) uniform image3D sum;

uint stepped(uint number, uint step) { return reduced_number(number + step, push.cell_count); }

float gradient_octave(vec3 q) {
  vec3 base = floor(q);
  vec3 f = q - base;
  vec3 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  uint first = cell_number(base, push.step, push.cell_count);
  float value = 0.0;
  for (int i = 0; i < 8; ++i) {
    ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2);
    uint number = first;
    if (corner.x == 1) number = stepped(number, push.step.x);
    if (corner.y == 1) number = stepped(number, push.step.y);
    if (corner.z == 1) number = stepped(number, push.step.z);
    vec3 g = cell_hash(number, push.seed) * 2.0 - 1.0;
    vec3 c = mix(1.0 - w, w, vec3(corner));
    value += c.x * c.y * c.z * dot(g, f - vec3(corner));
  }
  return value;
}

// Rounded domes with sharp creases between them: the surface of a cauliflower.
float dome_octave(vec3 q) {
  vec3 base = floor(q);
  vec3 f = q - base;
  uint slab = cell_number(base - 1.0, push.step, push.cell_count);
  float nearest = 1.5;
  for (int z = -1; z <= 1; ++z) {
    uint row = slab;
    for (int y = -1; y <= 1; ++y) {
      uint number = row;
      for (int x = -1; x <= 1; ++x) {
        vec3 d = vec3(x, y, z) + cell_hash(number, push.seed) - f;
        nearest = min(nearest, dot(d, d));
        number = stepped(number, push.step.x);
      }
      row = stepped(row, push.step.y);
    }
    slab = stepped(slab, push.step.z);
  }
  return 1.0 - nearest;
}

void main() {
  ivec3 id = ivec3(gl_GlobalInvocationID);
  if (id.x >= int(push.size) || id.y >= int(push.size)) return;
  vec3 p = (vec3(id) + 0.5) / float(push.size);
  float value = 0.0;
  if (kDome) {
    value = dome_octave(push.cells_from_uvw * (p + push.bend * bend_direction(p)) + push.shift);
  } else {
    value = gradient_octave(push.cells_from_uvw * p + push.shift);
  }
  imageStore(sum, id, imageLoad(sum, id) + push.weight * value);
}
