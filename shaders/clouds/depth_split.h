// Two depths that stand for all that a ray meets of the clouds, so that air, haze and the height of the light are right where
// thin cloud is before far cloud (docs/light.md, 'Air before clouds').
//
// The march sums powers of a place x of what each step hides. Two nodes with weights that have the same sums of x^0 to x^3 are
// Gauss's quadrature for that measure: whatever is a cubic of x is exact, and so are any two thin sheets, at every x. Nodes are
// smooth functions of the sums: nothing is cut, so no seam shows.
#ifndef NEPHO_DEPTH_SPLIT_H
#define NEPHO_DEPTH_SPLIT_H
#include "common/shared.h"
SHARED_BEGIN

// Places grow like distances near the ray's first cloud and ever slower far away, as air hides more and more: 0 there, 1 at
// infinity. Small numbers near the first cloud keep the sums' digits.
SHARED_CONST float kSplitBend_m = 5.0e3f;
SHARED_FN float split_place(float distance_m, float first_m) { return (distance_m - first_m) / (distance_m + kSplitBend_m); }
SHARED_FN float split_distance(float x, float first_m) { return (first_m + kSplitBend_m * x) / (1.0f - x); }

struct DepthSplit {
  float near_x, far_x;  // places of the nodes; equal where there is but one
  float near_share;     // of the whole weight
};

// `sums`: of w, w x, w x^2, w x^3 over the steps; sums.x > 0.
SHARED_FN DepthSplit split_depths(vec4 sums) {
  vec3 m = vec3(sums.y, sums.z, sums.w) / sums.x;
  float variance = m.y - m.x * m.x;
  DepthSplit split;
  split.near_x = split.far_x = clamp(m.x, 0.0f, 0.999f);
  split.near_share = 0.0f;
  if (variance > 1.0e-10f) {
    float deviation = sqrt(variance);
    float skew = (m.z - 3.0f * m.x * m.y + 2.0f * m.x * m.x * m.x) / (variance * deviation);
    // Roots of y^2 - skew y - 1, the nodes in deviations from the mean.
    float root = sqrt(skew * skew + 4.0f);
    float y = skew > 0.0f ? 0.5f * (root + skew) : 2.0f / (root - skew);
    split.near_x = clamp(m.x - deviation / y, 0.0f, 0.999f);
    split.far_x = clamp(m.x + deviation * y, 0.0f, 0.999f);
    split.near_share = y * y / (1.0f + y * y);
  }
  return split;
}

// Of a quantity with the sums q and q x over the steps: what goes to the near node, so that both sums stay.
SHARED_FN float split_near_part(DepthSplit split, float q, float q_x) {
  float apart = split.far_x - split.near_x;
  return apart > 0.0f ? q - clamp((q_x - split.near_x * q) / apart, 0.0f, q) : 0.0f;
}

SHARED_END
#endif
