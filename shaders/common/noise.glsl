// Hash noise that every generator of ours shares: gradient (Perlin 2002) and cellular (Worley 1996), on a lattice that
// wraps at `period` cells (pass a huge period for none). Hash: PCG3D, Jarzynski and Olano 2020.
#ifndef NEPHO_COMMON_NOISE_GLSL
#define NEPHO_COMMON_NOISE_GLSL

uvec3 pcg3d(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

ivec3 wrapped(ivec3 cell, int period) { return cell - period * ivec3(floor((vec3(cell) + 0.5) / float(period))); }

vec3 hash3(ivec3 cell, int period, uint seed) {
  uvec3 h = pcg3d(uvec3(wrapped(cell, period)) + seed * uvec3(0x9e3779b9u, 0x85ebca6bu, 0xc2b2ae35u));
  return vec3(h >> 8u) * (1.0 / 16777216.0);
}

// About -1..1, mean 0.
float gradient_noise(vec3 p, int period, uint seed) {
  vec3 base = floor(p);
  vec3 f = p - base;
  vec3 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  float sum = 0.0;
  for (int i = 0; i < 8; ++i) {
    ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2);
    vec3 g = hash3(ivec3(base) + corner, period, seed) * 2.0 - 1.0;
    vec3 c = mix(1.0 - w, w, vec3(corner));
    sum += c.x * c.y * c.z * dot(g, f - vec3(corner));
  }
  return sum;
}

// Distance to the nearest of one random point per cell, in cells.
float worley_distance(vec3 p, int period, uint seed) {
  vec3 base = floor(p);
  vec3 f = p - base;
  float best = 8.0;
  for (int i = 0; i < 27; ++i) {
    ivec3 offset = ivec3(i % 3, (i / 3) % 3, i / 9) - 1;
    vec3 d = vec3(offset) + hash3(ivec3(base) + offset, period, seed) - f;
    best = min(best, dot(d, d));
  }
  return sqrt(best);
}

#endif
