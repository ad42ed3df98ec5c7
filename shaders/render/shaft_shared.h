// Light shafts and haze along rays: data and pure functions for C++ and GLSL (docs/light.md, 'Shafts').
#ifndef NEPHO_SHAFT_SHARED_H
#define NEPHO_SHAFT_SHARED_H
#include "render/haze_shared.h"
SHARED_BEGIN

// Constant for a scene, but for the ground's height.
struct ShaftData {
  HazeData haze;
  float shade_top_m;     // scaled height that no shade reaches; below the ground: no shadows
  float intensity;       // 1: the share of the sun that clouds take is taken
  float ground_m;        // scaled height of the ground around the camera: where haze ends
  float ground_albedo;
};

// A frustum grid of the air: cells even across the picture, slices from start_m to end_m.
struct FroxelGrid {
  uvec3 size;
  float start_m;         // distance of the first slice's near side
  float end_m;
  float growth;          // ln of the last slice's depth over the first's, about; > 0
};

// Distance of slice x, 0..size.z, and back: exponential from the start on.
SHARED_FN float froxel_distance(FroxelGrid grid, float x) {
  float u = x / float(grid.size.z);
  return grid.start_m + (grid.end_m - grid.start_m) * (exp(grid.growth * u) - 1.0f) / (exp(grid.growth) - 1.0f);
}
SHARED_FN float froxel_slice(FroxelGrid grid, float distance_m) {
  float u = clamp((distance_m - grid.start_m) / (grid.end_m - grid.start_m), 0.0f, 1.0f);
  return float(grid.size.z) * log(1.0f + u * (exp(grid.growth) - 1.0f)) / grid.growth;
}

// A stretch of a ray in up to three parts, each with its share of the steps, denser at its near end where the air is thick.
struct StepPlan {
  vec4 cut_m;            // ascending distances: start, two cuts, end
  vec3 fall;             // of each part: optical depth that its steps follow
  vec3 first;            // number of the first step of each part
  float steps;
};

SHARED_FN StepPlan plan_steps(vec4 cut_m, vec3 extinction_per_m, float steps) {
  StepPlan plan;
  plan.cut_m = cut_m;
  plan.steps = steps;
  vec3 length_m = vec3(cut_m.y - cut_m.x, cut_m.z - cut_m.y, cut_m.w - cut_m.z);
  plan.fall = clamp(extinction_per_m * length_m, vec3(1.0e-3f), vec3(6.0f));
  float total = length_m.x + length_m.y + length_m.z;
  // A quarter of the steps for the parts before and behind the middle, where these are not empty.
  float before = length_m.x > 1.0e-3f * total ? floor(0.25f * steps) : 0.0f;
  float behind = length_m.z > 1.0e-3f * total ? floor(0.25f * steps) : 0.0f;
  float middle = length_m.y > 1.0e-3f * total ? steps - before - behind : 0.0f;
  if (middle < 0.5f) before = behind > 0.5f ? floor(0.5f * steps) * float(before > 0.5f) : steps;
  if (middle < 0.5f) behind = steps - before;
  plan.first = vec3(0.0f, before, steps - behind);
  return plan;
}

// Distance of step x, 0..steps.
SHARED_FN float step_distance(StepPlan plan, float x) {
  int part = x < plan.first.y ? 0 : x < plan.first.z ? 1 : 2;
  float from = part == 0 ? plan.first.x : part == 1 ? plan.first.y : plan.first.z;
  float to = part == 0 ? plan.first.y : part == 1 ? plan.first.z : plan.steps;
  float a = part == 0 ? plan.cut_m.x : part == 1 ? plan.cut_m.y : plan.cut_m.z;
  float b = part == 0 ? plan.cut_m.y : part == 1 ? plan.cut_m.z : plan.cut_m.w;
  float fall = part == 0 ? plan.fall.x : part == 1 ? plan.fall.y : plan.fall.z;
  float u = clamp((x - from) / max(to - from, 1.0f), 0.0f, 1.0f);
  return a + (b - a) * min(-log(1.0f - u * (1.0f - exp(-fall))) / fall, 1.0f);
}

// How near two distances are for the choice between depths: even near the camera, in proportion far away.
SHARED_FN float shaft_depth(float distance_m) { return distance_m / (distance_m + 5.0e3f); }

// About how much of the light that shade can take from a ray lies up to a distance, 0..1; entry_m: where shade may begin.
SHARED_CONST float kAirReach_m = 40.0e3f;
SHARED_FN float shaft_share(float distance_m, float entry_m) {
  float x = max(distance_m - entry_m, 0.0f) / kAirReach_m;
  return x < 1.0e-2f ? x * (1.0f - 0.5f * x) : 1.0f - exp(-x);
}

struct ShaftMarchPush {
  uvec2 block;           // sides of the blocks of pixels that share a ray
  uint has_clouds;       // 1: cloud_depths holds clouds' depths
  float glow;            // of screen: optical depth of what glows around the sun over clouds
};
struct FroxelApplyPush {
  FroxelGrid grid;
  uint has_clouds;
};
struct ShaftApplyPush {
  uvec2 block;
  uint has_clouds;
  float top_m;           // scaled height that neither shade nor haze reaches
};

SHARED_END
#endif
