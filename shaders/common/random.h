// Random numbers that depend on nothing but who asks: the same on every device and for every order of work.
#ifndef NEPHO_COMMON_RANDOM_H
#define NEPHO_COMMON_RANDOM_H
#include "common/shared.h"
SHARED_BEGIN

// Four well mixed words from four: pcg4d of Jarzynski and Olano 2020, 'Hash Functions for GPU Rendering', JCGT 9(3).
SHARED_FN uvec4 hash4(uvec4 v) {
  v = v * 1664525u + uvec4(1013904223u);
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v = v ^ (v >> 16u);
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// A stream of numbers: PCG-RXS-M-XS 32 (O'Neill 2014) with an increment of its own, so that streams of different
// (pixel, sample, seed) neither start nor step alike.
struct Random {
  uint state;
  uint increment;  // odd
};

SHARED_FN Random random_stream(uint pixel, uint sample_index, uint seed) {
  // Twice: after one round the highest bits of what is hashed have not reached the lowest ones yet.
  uvec4 h = hash4(hash4(uvec4(pixel, sample_index, seed, 0x9e3779b9u)));
  Random r;
  r.state = h.x;
  r.increment = h.y | 1u;
  return r;
}

SHARED_FN uint random_next(SHARED_INOUT(Random) r) {
  uint old = r.state;
  r.state = old * 747796405u + r.increment;
  uint word = ((old >> ((old >> 28u) + 4u)) ^ old) * 277803737u;
  return (word >> 22u) ^ word;
}

// [0, 1), multiples of 2^-24.
SHARED_FN float random_unit(SHARED_INOUT(Random) r) { return float(random_next(r) >> 8u) * (1.0f / 16777216.0f); }

SHARED_END
#endif
