#version 460
#extension GL_GOOGLE_include_directive : require
// In sequences: what the last frame's cells know of the light in this frame's, and which of these want paths: all that have no light
// yet, and in turns the others.
#include "clouds/light_shared.h"
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform BeforeBlock { FrameConstants data; } before;
layout(scalar, set = 0, binding = 2) uniform LightBlock { CloudLightConstants data; } light;
#include "clouds/light_before.glsl"
layout(scalar, set = 0, binding = 3) buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 4) readonly buffer ListBlock { uint at[]; } list;
layout(scalar, set = 0, binding = 5) writeonly buffer FreshBlock { uint at[]; } fresh;
layout(scalar, set = 0, binding = 6) writeonly buffer RefreshBlock { uint at[]; } refresh;
layout(set = 0, binding = 7) uniform sampler3D before_cells;
layout(set = 0, binding = 8, rgba16f) uniform writeonly image3D out_cells;

const float kTurn_rad = 0.15;  // light towards the eye changes when it is seen from elsewhere

// Light and weight (in full sets of paths) of the last frame's cells around a cell's place.
vec4 light_before(ivec3 at) {
  FrameConstants f = frame.frame_data, b = before.data;
  LightCells cells = light.data.cells;
  ivec3 size = ivec3(cells.nodes, cells.slices);
  vec3 dir = light_node_direction(f, cells, uvec2(at.xy));
  float entry = light_entry(f.planet, light.data.grid, dir);
  vec3 q = dir * (max(entry, 0.0) + light_slice_m(cells, float(at.z) + 0.5)) + light.data.moved_m;
  float far_m = length(q);
  vec3 to = q / max(far_m, 1.0e-3);
  vec2 node;
  if (entry < 0.0 || !light_before_node(q, cells, node)) return vec4(0.0);
  float entry_before = light_entry(b.planet, light.data.grid, to);
  if (entry_before < 0.0 || far_m < entry_before) return vec4(0.0);
  vec2 slice = light_snap(vec2(light_slice(cells, far_m - entry_before) - 0.5, 0.0));
  node = light_snap(node);
  int k = int(floor(slice.x));
  ivec2 corner = ivec2(floor(node));
  vec2 fn = node - vec2(corner);
  float t = slice.x - float(k);
  // Nodes linearly, as numbers of paths; slices, which move little from frame to frame, by a cubic that hardly blurs.
  vec4 row[4];
  for (int j = 0; j < 4; ++j) {
    row[j] = vec4(0.0);
    for (int n = 0; n < 4; ++n) {
      ivec3 there = ivec3(corner + ivec2(n & 1, n >> 1), k - 1 + j);
      float w = ((n & 1) != 0 ? fn.x : 1.0 - fn.x) * ((n >> 1) != 0 ? fn.y : 1.0 - fn.y);
      if (w <= 0.0 || any(lessThan(there, ivec3(0))) || any(greaterThanEqual(there, size))) continue;
      vec4 cell = texelFetch(before_cells, there, 0);
      row[j] += w * cell.a * vec4(cell.rgb, 1.0);
    }
  }
  vec4 sum = (1.0 - t) * row[1] + t * row[2];
  if (sum.a <= 0.0) return vec4(0.0);
  vec3 mean = sum.rgb / sum.a;
  if (t > 0.0 && min(min(row[0].a, row[1].a), min(row[2].a, row[3].a)) > 0.0) {
    vec3 p0 = row[0].rgb / row[0].a, p1 = row[1].rgb / row[1].a, p2 = row[2].rgb / row[2].a, p3 = row[3].rgb / row[3].a;
    vec3 cubic = p1 + 0.5 * t * (p2 - p0 + t * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + t * (3.0 * (p1 - p2) + p3 - p0)));
    mean = clamp(cubic, min(p1, p2), max(p1, p2));
  }
  return vec4(mean, sum.a * exp(-length(cross(dir, to)) / kTurn_rad));
}

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (gl_LocalInvocationID.x < 2u) light_counts[gl_LocalInvocationID.x] = 0u;
  barrier();
  uint cell = 0u, wants = 0u, place = 0u;
  if (item < work.data.count) {
    LightCells cells = light.data.cells;
    cell = list.at[item];
    ivec3 at = ivec3(int((cell / cells.slices) % cells.nodes.x), int(cell / cells.slices / cells.nodes.x), int(cell % cells.slices));
    vec4 known = light.data.still != 0u ? texelFetch(before_cells, at, 0) : light_before(at);
    known.a = min(known.a * light.data.keep, light.data.most_weight);
    imageStore(out_cells, at, known);
    wants = light_wants(cell, known.a);
    if (wants > 0u) place = atomicAdd(light_counts[wants - 1u], 1u);
  }
  barrier();
  if (gl_LocalInvocationID.x == 0u && light_counts[0] > 0u) light_firsts[0] = atomicAdd(work.data.fresh, light_counts[0]);
  if (gl_LocalInvocationID.x == 1u && light_counts[1] > 0u) light_firsts[1] = atomicAdd(work.data.refresh, light_counts[1]);
  barrier();
  if (wants == 1u) fresh.at[light_firsts[0] + place] = cell;
  if (wants == 2u) refresh.at[light_firsts[1] + place] = cell;
}
