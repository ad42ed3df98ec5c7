#version 460
#extension GL_GOOGLE_include_directive : require
// As light_history.comp, for the nodes on the ground: what the last frame's know of the light on theirs.
#include "clouds/light_shared.h"
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform BeforeBlock { FrameConstants data; } before;
layout(scalar, set = 0, binding = 2) uniform LightBlock { CloudLightConstants data; } light;
#include "clouds/light_before.glsl"
#include "clouds/light_nodes.glsl"
layout(scalar, set = 0, binding = 3) buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 5) writeonly buffer FreshBlock { uint at[]; } fresh;
layout(scalar, set = 0, binding = 6) writeonly buffer RefreshBlock { uint at[]; } refresh;
layout(set = 0, binding = 7) uniform sampler2D before_ground;
layout(set = 0, binding = 8) uniform sampler2D before_weight;
layout(set = 0, binding = 9) uniform sampler2D depth_m;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_ground;
layout(set = 0, binding = 11, r32f) uniform writeonly image2D out_weight;

vec4 light_before(ivec2 at, float distance_m) {
  FrameConstants f = frame.frame_data, b = before.data;
  LightCells cells = light.data.cells;
  vec3 p = light_ground_direction(f, cells, uvec2(at)) * distance_m, q = p + light.data.moved_m;
  vec2 node;
  if (!light_before_node(q, cells, node)) return vec4(0.0);
  node = light_snap(node);
  ivec2 corner = ivec2(floor(node));
  vec2 fn = node - vec2(corner);
  float near_m = light_ground_radius_m(f.planet, light.data.grid, p);
  vec3 places[4];
  vec4 found[4];
  float weights[4];
  vec3 low = vec3(1.0e20), high = vec3(-1.0e20);
  for (int n = 0; n < 4; ++n) {
    ivec2 there = clamp(corner + ivec2(n & 1, n >> 1), ivec2(0), ivec2(cells.nodes) - 1);
    found[n] = texelFetch(before_ground, there, 0);
    weights[n] = ((n & 1) != 0 ? fn.x : 1.0 - fn.x) * ((n >> 1) != 0 ? fn.y : 1.0 - fn.y) * texelFetch(before_weight, there, 0).r;
    if (found[n].a >= 0.5 * kFarDepth_m) weights[n] = 0.0;
    places[n] = light_ground_direction(b, cells, uvec2(there)) * found[n].a;
    if (weights[n] > 0.0) {
      low = min(low, places[n]);
      high = max(high, places[n]);
    }
  }
  // Nodes that hold the place between them may lie far apart along the ground.
  float reach_m = max(near_m, low.x < high.x ? min(length(high - low), 0.2 * length(q)) : 0.0);
  vec4 sum = vec4(0.0);
  for (int n = 0; n < 4; ++n)
    if (weights[n] > 0.0 && length(places[n] - q) < reach_m) sum += weights[n] * vec4(found[n].rgb, 1.0);
  return sum.a > 0.0 ? vec4(sum.rgb / sum.a, sum.a) : vec4(0.0);
}

void main() {
  uint node = gl_GlobalInvocationID.x;
  LightCells cells = light.data.cells;
  if (gl_LocalInvocationID.x < 2u) light_counts[gl_LocalInvocationID.x] = 0u;
  barrier();
  uint wants = 0u, place = 0u;
  if (node < cells.nodes.x * cells.nodes.y) {
    ivec2 at = ivec2(int(node % cells.nodes.x), int(node / cells.nodes.x));
    float distance_m = texelFetch(depth_m, light_ground_pixel(frame.frame_data, cells, uvec2(at)), 0).r;
    vec4 known = vec4(0.0);
    if (distance_m < 0.5 * kFarDepth_m) {
      known = light.data.still != 0u ? vec4(texelFetch(before_ground, at, 0).rgb, texelFetch(before_weight, at, 0).r) : light_before(at, distance_m);
      known.a = min(known.a * light.data.keep, light.data.most_weight);
      wants = light_wants(node, known.a);
      if (wants > 0u) place = atomicAdd(light_counts[wants - 1u], 1u);
    }
    imageStore(out_ground, at, vec4(known.rgb, distance_m));
    imageStore(out_weight, at, vec4(known.a));
  }
  barrier();
  if (gl_LocalInvocationID.x == 0u && light_counts[0] > 0u) light_firsts[0] = atomicAdd(work.data.ground_fresh, light_counts[0]);
  if (gl_LocalInvocationID.x == 1u && light_counts[1] > 0u) light_firsts[1] = atomicAdd(work.data.ground_refresh, light_counts[1]);
  barrier();
  if (wants == 1u) fresh.at[light_firsts[0] + place] = node;
  if (wants == 2u) refresh.at[light_firsts[1] + place] = node;
}
