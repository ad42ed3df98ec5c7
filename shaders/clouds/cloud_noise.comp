#version 460
#extension GL_GOOGLE_include_directive : require
// Tileable noise volumes, raw; cloud_noise.cpp gives them their distribution and mips (docs/cloud_noise.md).
#include "common/noise.glsl"
#include "clouds/cloud_noise_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint kKind = 0u;
layout(push_constant, scalar) uniform Push { CloudNoisePush push; };
layout(set = 0, binding = 0, rgba32f) uniform writeonly image3D out_noise;

// Every lattice gets its own shift: gradient noise is 0 at its lattice points, and where those of several octaves or
// channels meet, rows show. A shifted tileable noise is tileable.
vec3 lattice_shift(uint seed) { return hash3(ivec3(int(seed & 0xffffu), 17, 5), 1 << 20, seed); }

// Rounded domes with sharp creases between them: the surface of a cauliflower.
float dome(vec3 p, int cycles, uint seed) {
  float d = worley_distance(p * float(cycles) + lattice_shift(seed), cycles, seed);
  return 1.0 - min(d * d, 1.5);
}

float perlin(vec3 p, int cycles, int octaves, float gain, uint seed) {
  float sum = 0.0, amplitude = 1.0;
  for (int i = 0; i < octaves; ++i) {
    uint s = seed + uint(i);
    sum += amplitude * gradient_noise(p * float(cycles) + lattice_shift(s), cycles, s);
    amplitude *= gain;
    cycles *= 2;
  }
  return sum;
}

vec3 perlin3(vec3 p, int cycles, int octaves, float gain, uint seed) {
  vec3 v;
  for (int c = 0; c < 3; ++c) v[c] = perlin(p, cycles, octaves, gain, seed + 16u * uint(c));
  return v;
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  if (id.x >= push.size || id.y >= push.size) return;
  vec3 p = (vec3(id) + 0.5) / float(push.size);
  uint seed = push.seed + 4096u * kKind;
  uint bend_seed = seed + 1024u;
  vec4 value = vec4(0.0);
  // Lattices are bent by a noise of their own scale, so that no rows align.
  if (kKind == kNoiseField) {
    vec3 bent = p + 0.05 * perlin3(p, 4, 2, 0.5, bend_seed);
    for (int c = 0; c < 4; ++c) value[c] = perlin(bent, 4, 5, 0.62, seed + 16u * uint(c));
  } else if (kKind == kNoiseCells) {
    vec3 bent = p + 0.035 * perlin3(p, 6, 2, 0.5, bend_seed);
    value.x = 0.60 * dome(bent, 9, seed) + 0.40 * dome(bent, 17, seed + 1u) + 0.45 * perlin(p, 7, 3, 0.6, seed + 16u);
    value.y = perlin(bent, 8, 4, 0.6, seed + 32u);
  } else if (kKind == kNoiseShape) {
    vec3 bent = p + 0.018 * perlin3(p, 8, 2, 0.5, bend_seed);
    value.x = 0.54 * dome(bent, 8, seed) + 0.30 * dome(bent, 17, seed + 1u) + 0.17 * dome(bent, 35, seed + 2u) +
              0.30 * perlin(p, 7, 3, 0.55, seed + 16u);
  } else if (kKind == kNoiseDetail) {
    value.x = 0.62 * dome(p, 4, seed) + 0.38 * dome(p, 8, seed + 1u);
  } else {
    value.xyz = perlin3(p, 4, 3, 0.35, seed);
  }
  imageStore(out_noise, ivec3(id), value);
}
