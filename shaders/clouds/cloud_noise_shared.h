// Layout of the generator of the clouds' noise volumes (docs/cloud_noise.md).
#ifndef NEPHO_CLOUD_NOISE_SHARED_H
#define NEPHO_CLOUD_NOISE_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// One octave: a noise on a lattice of its own. Whole numbers in cells_from_uvw make it tile the unit cube.
struct NoiseTerm {
  mat3 cells_from_uvw;  // rows nearly orthogonal, their lengths the octave's cycles
  uvec3 step;           // what a cell's number grows by along the lattice's axes, modulo cell_count
  uint cell_count;      // in the unit cube: the determinant
  vec3 shift;           // of the lattice, in cells
  float weight;
  float bend;           // domes: how far their places are moved, in uvw
  uint seed;
  uint size;            // texels a side of the volume
};

// Cells that the period makes equal have the same number: (x, y, z) . step modulo cell_count, which is 0 for whole periods
// and for nothing else (noise_recipe.cpp finds such steps). number < 2 * cell_count.
SHARED_FN uint reduced_number(uint number, uint cell_count) { return min(number, number - cell_count); }

// The number of a cell; coordinates within +-256.
SHARED_FN uint cell_number(vec3 cell, uvec3 step, uint cell_count) {
  int n = int(cell.x) * int(step.x) + int(cell.y) * int(step.y) + int(cell.z) * int(step.z);
  n -= int(floor(float(n) / float(cell_count))) * int(cell_count);  // off by one period at most
  n += n < 0 ? int(cell_count) : 0;
  return reduced_number(uint(n), cell_count);
}

// Three values 0..1 of a cell, in steps of 1 / 1024. Hash: lowbias32, Wellons 2018.
SHARED_FN vec3 cell_hash(uint number, uint seed) {
  uint h = number + seed;
  h ^= h >> 16u;
  h *= 0x7feb352du;
  h ^= h >> 15u;
  h *= 0x846ca68bu;
  h ^= h >> 16u;
  return (vec3(ivec3(int(h & 1023u), int((h >> 10u) & 1023u), int((h >> 20u) & 1023u))) + 0.5f) / 1024.0f;
}

// A smooth periodic displacement, some -1..1 each way.
SHARED_FN vec3 bend_direction(vec3 p) {
  vec3 a = 2.0f * kPi * vec3(3.0f * p.y + p.z - p.x, 3.0f * p.z + p.x - p.y, 3.0f * p.x + p.y - p.z);
  vec3 b = 2.0f * kPi * vec3(4.0f * p.z - 3.0f * p.y + 2.0f * p.x, 4.0f * p.x - 3.0f * p.z + 2.0f * p.y,
                             4.0f * p.y - 3.0f * p.x + 2.0f * p.z);
  return 0.6f * sin(a) + 0.4f * sin(b + 1.0f);
}

SHARED_END
#endif
