#version 460
#extension GL_GOOGLE_include_directive : require
// Means and squared differences of what the paths of each ray brought home: a workgroup a ray, its paths in turn to its
// invocations, whose sums are then joined in pairs.
#include "clouds/path_mean_shared.h"
#include "clouds/path_shared.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) readonly buffer ResultBlock { PathResult at[]; } results;
layout(scalar, set = 0, binding = 1) readonly buffer PlanBlock { PathPlan at[]; } plan;
layout(scalar, set = 0, binding = 2) writeonly buffer MeanBlock { PathMean at[]; } means;

shared PathMean parts[64];

void main() {
  uint ray = gl_WorkGroupID.x, lane = gl_LocalInvocationID.x;
  uint end = plan.at[ray + 1u].first_item;
  PathMean sum = PathMean(0u, MeanOf(0.0, 0.0), MeanOf(0.0, 0.0));
  for (uint i = plan.at[ray].first_item + lane; i < end; i += 64u)
    sum = path_means_joined(sum, PathMean(1u, MeanOf(results.at[i].sunlit.x, 0.0), MeanOf(results.at[i].weight.x, 0.0)));
  parts[lane] = sum;
  barrier();
  for (uint half_of = 32u; half_of > 0u; half_of /= 2u) {
    if (lane < half_of) parts[lane] = path_means_joined(parts[lane], parts[lane + half_of]);
    barrier();
  }
  if (lane == 0u) means.at[ray] = parts[0];
}
