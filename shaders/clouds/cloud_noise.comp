#version 460
#extension GL_GOOGLE_include_directive : require
// Tileable noise volumes, raw; cloud_noise.cpp normalises them and makes their mips (docs/clouds.md, 'Noise').
#include "common/noise.glsl"
#include "clouds/clouds_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { CloudNoisePush push; };
layout(set = 0, binding = 0, rg32f) uniform writeonly image3D out_noise;

// Rounded domes with sharp creases between them: the surface of a cauliflower.
float dome(vec3 p, int frequency, uint seed) {
  float d = worley_distance(p * float(frequency), frequency, seed);
  return 1.0 - min(d * d, 1.5);
}

float perlin(vec3 p, int frequency, int octaves, float gain, uint seed) {
  float sum = 0.0, amplitude = 1.0;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * gradient_noise(p * float(frequency), frequency, seed + uint(i));
    amplitude *= gain;
    frequency *= 2;
  }
  return sum;
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  if (id.x >= push.size || id.y >= push.size) return;
  vec3 p = (vec3(id) + 0.5) / float(push.size);
  uint seed = push.seed;
  vec2 value = vec2(0.0);
  if (push.kind == kCloudNoiseField) {
    // x: fractal field, y: convective cells; lattices bent by Perlin noise.
    vec3 turned = p + 0.05 * vec3(perlin(p, 4, 2, 0.5, seed + 40u), perlin(p, 4, 2, 0.5, seed + 44u), perlin(p, 4, 2, 0.5, seed + 48u));
    value.x = perlin(turned, 4, 4, 0.62, seed);
    vec3 bent = p + 0.035 * vec3(perlin(p, 6, 2, 0.5, seed + 8u), perlin(p, 6, 2, 0.5, seed + 16u), perlin(p, 6, 2, 0.5, seed + 24u));
    value.y = 0.60 * dome(bent, 9, seed + 32u) + 0.40 * dome(bent, 17, seed + 33u) + 0.45 * perlin(p, 7, 3, 0.6, seed + 34u);
  } else if (push.kind == kCloudNoiseShape) {
    vec3 bent = p + 0.018 * vec3(perlin(p, 8, 2, 0.5, seed + 8u), perlin(p, 8, 2, 0.5, seed + 16u), perlin(p, 8, 2, 0.5, seed + 24u));
    value.x = 0.54 * dome(bent, 8, seed) + 0.30 * dome(bent, 17, seed + 1u) + 0.17 * dome(bent, 35, seed + 2u) +
              0.30 * perlin(p, 7, 3, 0.55, seed + 3u);
  } else {
    value.x = 0.62 * dome(p, 4, seed) + 0.38 * dome(p, 8, seed + 1u);
  }
  imageStore(out_noise, ivec3(id), vec4(value, 0.0, 0.0));
}
